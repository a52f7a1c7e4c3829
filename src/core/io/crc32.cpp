// SPDX-License-Identifier: Apache-2.0
#include "core/io/crc32.h"

#include <array>

namespace brume {
namespace {

/// Bytes that are taken at once; table [k] holds the effect of a byte k places before the last.
constexpr std::size_t kSlice = 8;
using Tables = std::array<std::array<std::uint32_t, 256>, kSlice>;

constexpr Tables makeTables() {
  Tables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
    tables[0][i] = c;
  }
  for (std::size_t k = 1; k < kSlice; ++k)
    for (std::size_t i = 0; i < 256; ++i)
      tables[k][i] = tables[0][tables[k - 1][i] & 0xff] ^ (tables[k - 1][i] >> 8);
  return tables;
}
constexpr Tables kTables = makeTables();

}  // namespace

void Crc32::add(ByteSpan bytes) {
  std::uint32_t crc = state_;
  for (; bytes.size() >= kSlice; bytes = bytes.subspan(kSlice)) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < kSlice; ++i) {
      const std::uint32_t before = i < 4 ? crc >> (8 * i) : 0;
      next ^= kTables[kSlice - 1 - i][(before ^ bytes[i]) & 0xff];
    }
    crc = next;
  }
  for (const unsigned char b : bytes) crc = kTables[0][(crc ^ b) & 0xff] ^ (crc >> 8);
  state_ = crc;
}

}  // namespace brume
