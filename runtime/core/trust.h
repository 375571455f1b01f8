/** The one trust policy of the process: which bundles may be run. */
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "chiasm/chiasm.h"
#include "core/minisign.h"

namespace chiasm::core {

struct Trust {
  int32_t policy = CHIASM_TRUST_ANY; /**< a chiasm_trust_policy */
  std::vector<PublicKey> keys;
};

/** Each key is a public key's text or a file's path. Throws Error: INVALID_ARGUMENT, FAILED_PRECONDITION once
 *  it was used. */
void set_trust(int32_t policy, const std::vector<std::string>& keys);
/** As set, else as the environment says. Throws Error (INVALID_ARGUMENT) where that is nonsense: nothing is
 *  run then. */
Trust get_trust();
/** The policy, which from now on no longer changes. */
const Trust& use_trust();

}  // namespace chiasm::core
