// SPDX-License-Identifier: Apache-2.0
#include "support/folders.h"

namespace brume::test {

std::filesystem::path sourceFolder() { return BRUME_SOURCE_DIR; }
std::filesystem::path binaryFolder() { return BRUME_BINARY_DIR; }

}  // namespace brume::test
