// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace brume {

/// The computer that measured, without its name on the network.
struct Machine {
  std::string processor, system;  ///< "Intel(R) Xeon(R) ...", "Linux 6.1.0"
  int processors = 0;             ///< threads that it can run at once
  std::uint64_t memory = 0;       ///< [bytes]
  double load = 0;                ///< average number of programs that wanted a processor just now
};
Machine thisMachine();

/// "2026-11-27 09:30 UTC".
std::string utcTime();

}  // namespace brume
