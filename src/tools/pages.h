// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace brume {

/// src/tools/pages/bench.html, put into the program when it is built (cmake/pages.cmake).
extern const std::string_view kBenchPage;

}  // namespace brume
