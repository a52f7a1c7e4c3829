// SPDX-License-Identifier: Apache-2.0
// Any bytes as a photon file, as they are and with a checksum that is right, so that what lies
// behind it is reached. What may come out is photons that are written as they were read, or a
// SceneError.
#include <algorithm>
#include <cstdlib>

#include "core/error.h"
#include "core/io/crc32.h"
#include "transport/photon_file.h"

namespace {

void decode(const brume::Bytes& bytes) {
  brume::PhotonFile file;
  try {
    file = brume::decodePhotonFile(bytes, "fuzz");
  } catch (const brume::SceneError&) {
    return;
  }
  brume::Bytes written;
  brume::encodePhotonFile(
      file, [&](brume::ByteSpan part) { written.insert(written.end(), part.begin(), part.end()); });
  if (written != bytes) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  constexpr std::size_t kLongest = 1 << 14;
  if (size > kLongest) return -1;  // not for the corpus
  brume::Bytes bytes(data, data + size);
  decode(bytes);
  if (size < 4) return 0;
  const std::uint32_t crc = brume::crc32(brume::ByteSpan(bytes).first(size - 4));
  for (std::size_t i = 0; i < 4; ++i)
    bytes[size - 4 + i] = static_cast<unsigned char>(crc >> (8 * i));
  decode(bytes);
  return 0;
}
