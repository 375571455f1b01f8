/** The one trust policy of the process: which bundles may be run. */
#pragma once

#include <string>
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
/** The policy that was set, else the environment's. Throws Error (INVALID_ARGUMENT) if the latter is invalid,
 *  so that nothing runs. */
Trust get_trust();
/** The policy; from now on it can no longer be set. */
const Trust& use_trust();

}  // namespace chiasm::core
