// Finds the peer of a bundle among the families' tables.
#include "batch.hpp"

namespace peers {

std::optional<Peer> opencv(const std::string& bundle, const Inputs& inputs) {
  for (const auto family : {color, enhance, filters, geometry, morphology, pipelines}) {
    const Table table = family();
    if (const auto found = table.find(bundle); found != table.end()) return found->second(inputs);
  }
  return std::nullopt;
}

}  // namespace peers
