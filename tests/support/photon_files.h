// SPDX-License-Identifier: Apache-2.0
// Photons and photon files for tests.
#pragma once

#include <bit>
#include <map>
#include <string>

#include "core/io/crc32.h"
#include "core/rng.h"
#include "transport/photon_file.h"

namespace brume::test {

inline Bytes bytesOf(const PhotonFile& file) {
  Bytes bytes;
  encodePhotonFile(file,
                   [&](ByteSpan part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  return bytes;
}

/// n photons of the classes 0 to 5 in turn, each class from 10 + class light paths.
inline PhotonFile somePhotons(std::size_t n, std::uint64_t seed = 1) {
  Rng rng(seed);
  PhotonFile file;
  file.origin = {100, -2.5, 1e7};
  file.seed = 0x0123456789abcdefull;
  for (std::size_t c = 0; c < kPhotonClasses; ++c) file.set.paths[c] = 10 + c;
  const auto number = [&] { return rng.uniform() - 0.5f; };
  for (std::size_t i = 0; i < n; ++i) {
    // In braces: from left to right, by every compiler.
    const Vec3 p{number(), number(), number()};
    const Vec3 wi = normalize(Vec3{number(), number(), number() + 2});
    const Rgb power{rng.uniform(), rng.uniform(), 1e-30f * rng.uniform()};
    const auto c = static_cast<PhotonClass>(i % kPhotonClasses);
    file.set.photons.push_back(kSurfacePhotons.contains(c) ? Photon::onSurface(p, wi, -wi, power, c)
                                                           : Photon::inMedium(p, wi, power, c));
  }
  return file;
}

inline void put32(Bytes& bytes, std::size_t at, std::uint32_t v) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<unsigned char>(v >> (8 * i));
}
/// Makes the checksum right again.
inline void sign(Bytes& bytes) {
  if (bytes.size() >= 4)
    put32(bytes, bytes.size() - 4, crc32(ByteSpan(bytes).first(bytes.size() - 4)));
}

/// The stored corpus of the fuzzer, tests/fuzz/corpus/photons.
inline std::map<std::string, Bytes> fuzzCorpus() {
  PhotonFile oneClass = somePhotons(1);
  oneClass.set.paths = {};
  oneClass.set.paths[0] = 1;
  Bytes otherVersion = bytesOf(somePhotons(1));
  put32(otherVersion, 12, 2);
  sign(otherVersion);
  return {{"none", bytesOf(somePhotons(0))},
          {"one", bytesOf(oneClass)},
          {"twelve", bytesOf(somePhotons(12))},
          {"version2", otherVersion}};
}

}  // namespace brume::test
