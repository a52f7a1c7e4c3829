// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace brume::test {

/// The checkout that the tests were built from, and the folder they were built in. (Functions, not
/// macros on every command line: objects are the same in every checkout, so that ccache shares
/// them.)
std::filesystem::path sourceFolder();
std::filesystem::path binaryFolder();

}  // namespace brume::test
