// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace brume {

/// "0.1.0", or "0.1.0 (commit 1a2b3c4)" when it was built from a checkout.
std::string_view version();

}  // namespace brume
