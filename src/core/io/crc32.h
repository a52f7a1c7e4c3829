// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/io/file_bytes.h"

namespace brume {

/// CRC-32 of ISO 3309, as PNG, gzip and zlib have it, of bytes that come in pieces.
class Crc32 {
 public:
  void add(ByteSpan bytes);
  std::uint32_t value() const { return ~state_; }

 private:
  std::uint32_t state_ = 0xffffffffu;
};

inline std::uint32_t crc32(ByteSpan bytes) {
  Crc32 crc;
  crc.add(bytes);
  return crc.value();
}

}  // namespace brume
