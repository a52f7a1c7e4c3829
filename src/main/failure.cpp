// SPDX-License-Identifier: Apache-2.0
#include "main/failure.h"

#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "core/error.h"
#include "core/log.h"
#include "core/version.h"

namespace brume {

int reportFailure() {
  const auto print = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  const auto printInternal = [&](const char* what) {
    print(formatDiagnostic({}, "internal error", what));
    print("  This is a fault of brume " + std::string(version()) +
          ", not of the scene; a report with the scene would help.");
    return kExitInternal;
  };
  try {
    throw;
  } catch (const SceneError& error) {
    print(formatDiagnostic(error.where(), "error", error.what()));
    return kExitUser;
  } catch (const std::bad_alloc&) {
    print(formatDiagnostic({}, "error",
                           "out of memory: the scene or its image needs more than "
                           "this process may have"));
    return kExitUser;
  } catch (const std::exception& error) {
    return printInternal(error.what());
  } catch (...) {
    return printInternal("an exception of unknown type");
  }
}

}  // namespace brume
