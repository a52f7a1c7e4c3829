// SPDX-License-Identifier: Apache-2.0
#include "core/version.h"

namespace brume {

std::string_view version() { return BRUME_VERSION; }

}  // namespace brume
