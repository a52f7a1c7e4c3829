// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_file.h"
#include "support/folders.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "core/error.h"
#include "support/photon_files.h"
#include "support/run_program.h"

namespace brume {
namespace {

using test::bytesOf;
using test::put32;
using test::sign;
using test::somePhotons;
using testing::HasSubstr;

/// What decoding says; empty when it finds nothing wrong.
std::string complaint(const Bytes& bytes) {
  try {
    decodePhotonFile(bytes, "map");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

bool areEqual(const PhotonFile& a, const PhotonFile& b) {
  const auto &p = a.set.photons, &q = b.set.photons;
  return a.origin == b.origin && a.seed == b.seed && a.set.paths == b.set.paths &&
         p.size() == q.size() &&
         (p.empty() || std::memcmp(p.data(), q.data(), p.size() * sizeof(Photon)) == 0);
}

TEST(Crc32, KnownValueInOnePieceAndInMany) {
  const std::string text = "The check value of CRC-32 is that of these: 123456789";
  const ByteSpan bytes(reinterpret_cast<const unsigned char*>(text.data()), text.size());
  EXPECT_EQ(crc32(bytes.last(9)), 0xcbf43926u);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    Crc32 crc;
    crc.add(bytes.first(cut));
    crc.add(bytes.subspan(cut));
    EXPECT_EQ(crc.value(), crc32(bytes)) << cut;
  }
}

TEST(PhotonFile, ReadsWhatItWrote) {
  for (const std::size_t n : {0, 1, 6, 5000}) {  // 5000: more than one piece
    const PhotonFile file = somePhotons(n);
    const Bytes bytes = bytesOf(file);
    EXPECT_EQ(bytes.size(), 256 + 32 * n + 4);
    EXPECT_TRUE(areEqual(decodePhotonFile(bytes, "map"), file)) << n;
  }
}

/// The bytes at the places that docs/photon_files.md names.
TEST(PhotonFile, LayoutIsAsDocumented) {
  const Bytes bytes = bytesOf(somePhotons(7));
  const auto u64 = [&](std::size_t at) {
    std::uint64_t v = 0;
    for (std::size_t i = 0; i < 8; ++i) v |= std::uint64_t{bytes[at + i]} << (8 * i);
    return v;
  };
  EXPECT_EQ(u64(0), 0x0a1a0a0d48504289u);
  EXPECT_EQ(u64(8), 0x0000000101020304u);
  EXPECT_EQ(u64(16), 0x0000002000000100u);
  EXPECT_EQ(u64(24), 7u);
  EXPECT_EQ(u64(32), 10u);
  EXPECT_EQ(u64(32 + 5 * 8), 15u);
  EXPECT_EQ(u64(80), 2u);  // photons 0 and 6
  EXPECT_EQ(u64(80 + 8), 1u);
  EXPECT_EQ(std::bit_cast<double>(u64(128 + 16)), 1e7);
  EXPECT_EQ(u64(176), 0x0123456789abcdefu);
  EXPECT_EQ(std::string(bytes.begin() + 184, bytes.begin() + 231),
            "position: scene unit; power: W, linear Rec. 709");
  const PhotonFile file = somePhotons(7);
  EXPECT_EQ(static_cast<std::uint32_t>(u64(256 + 32)),
            std::bit_cast<std::uint32_t>(file.set.photons[1].p.x));
  EXPECT_EQ(u64(256 + 32 + 24) >> 32 & 0xff, 1u);
}

TEST(PhotonFile, EveryTruncationIsAnError) {
  const Bytes bytes = bytesOf(somePhotons(3));
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_NE(complaint(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n))), "")
        << n;
  Bytes longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(complaint(longer),
            "'map' is damaged: 1 bytes follow the 3 photons that its header promises");
}

TEST(PhotonFile, EveryFlippedBitIsAnError) {
  Bytes bytes = bytesOf(somePhotons(3));
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      bytes[i] ^= static_cast<unsigned char>(1 << bit);
      EXPECT_NE(complaint(bytes), "") << i << " bit " << bit;
      bytes[i] ^= static_cast<unsigned char>(1 << bit);
    }
  EXPECT_EQ(complaint(bytes), "");
}

TEST(PhotonFile, SaysWhatIsWrong) {
  const std::string png("\x89PNG\r\n\x1a\n and more", 17);
  EXPECT_EQ(complaint(Bytes(png.begin(), png.end())), "'map' is not a photon file of brume");
  EXPECT_EQ(complaint({}), "'map' is not a photon file of brume");
  const Bytes good = bytesOf(somePhotons(3));
  EXPECT_EQ(complaint(Bytes(good.begin(), good.begin() + 100)),
            "'map' is truncated: it has 100 bytes, the header of a photon file alone 256");
  EXPECT_EQ(complaint(Bytes(good.begin(), good.begin() + 330)),
            "'map' is truncated: its header promises 3 photons, it has room for 2");
  const auto changed = [&](std::size_t at, std::uint32_t value, bool isSigned) {
    Bytes bytes = good;
    put32(bytes, at, value);
    if (isSigned) sign(bytes);
    return complaint(bytes);
  };
  EXPECT_EQ(changed(12, 7, true),
            "'map' is a photon file of version 7; this brume reads version 1");
  EXPECT_EQ(changed(8, 0x04030201, true), "'map' has its bytes in the wrong order");
  EXPECT_THAT(changed(300, 12345, false), HasSubstr("is damaged: the checksum of its contents is"));
}

TEST(PhotonFile, RightChecksumsDoNotExcuseWrongContents) {
  const Bytes good = bytesOf(somePhotons(3));
  const auto changed = [&](std::size_t at, std::uint32_t value) {
    Bytes bytes = good;
    put32(bytes, at, value);
    sign(bytes);
    return complaint(bytes);
  };
  constexpr std::uint32_t kNan = 0x7fc00000, kInfinite = 0x7f800000;
  // A count whose size in bytes does not fit into 64 bits, and one that would take 128 GiB.
  EXPECT_EQ(changed(28, 0xffffffff),
            "'map' is truncated: its header promises 18446744069414584323 photons, it has room "
            "for 3");
  EXPECT_EQ(changed(24, 0xffffffff),
            "'map' is truncated: its header promises 4294967295 photons, it has room for 3");
  EXPECT_THAT(changed(16, 512), HasSubstr("header of 256 and photons of 32 bytes"));
  EXPECT_THAT(changed(32, 0), HasSubstr("photon 0 is of a class without light paths"));
  EXPECT_THAT(changed(80, 9), HasSubstr("not those that its header counts"));
  EXPECT_THAT(changed(128 + 4, 0x7ff00000), HasSubstr("origin is not finite"));
  EXPECT_THAT(changed(152, 0xc0000000), HasSubstr("bounds are not those of its photons"));
  EXPECT_THAT(changed(184, 0x20202020), HasSubstr("has other units"));
  EXPECT_THAT(changed(240, 1), HasSubstr("reserved bytes"));
  EXPECT_THAT(changed(256 + 32, kNan), HasSubstr("power of photon 1 is not finite"));
  EXPECT_THAT(changed(256 + 64 + 12, kInfinite), HasSubstr("power of photon 2 is not finite"));
  EXPECT_THAT(changed(256 + 28, 6), HasSubstr("photon 0 is of the unknown class 6"));
}

TEST(PhotonFile, PositionsMoveToAnotherOrigin) {
  PhotonFile file = somePhotons(6);
  const PhotonFile before = file;
  file.moveTo(before.origin);
  EXPECT_TRUE(areEqual(file, before));
  file.moveTo(before.origin + Vec3d(-3, 0.25, 1024));
  EXPECT_EQ(file.origin, before.origin + Vec3d(-3, 0.25, 1024));
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3d world = Vec3d(file.set.photons[i].p) + file.origin;
    const Vec3d exact = Vec3d(before.set.photons[i].p) + before.origin;
    EXPECT_NEAR(world.x, exact.x, 3e-7);  // floats up to 4
    EXPECT_NEAR(world.z, exact.z, 7e-5);  // floats up to 1025
  }
}

TEST(PhotonFile, AppearsWholeOrNotAtAll) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "map.photons").string();
  const PhotonFile file = somePhotons(100);
  writePhotonFile(path, file);
  EXPECT_TRUE(areEqual(readPhotonFile(path), file));
  EXPECT_EQ(folder.files(), std::vector<std::string>{"map.photons"});
  EXPECT_THROW(writePhotonFile((folder.path() / "none" / "map").string(), file), SceneError);
  EXPECT_THROW(readPhotonFile((folder.path() / "missing").string()), SceneError);
  EXPECT_THROW(readPhotonFile(folder.path().string()), SceneError);
}

/// The fuzzer starts from files that hold what this version writes. BRUME_WRITE_CORPUS=1 renews
/// them.
TEST(PhotonFile, FuzzCorpusIsCurrent) {
  const std::filesystem::path folder =
      test::sourceFolder() / "tests" / "fuzz" / "corpus" / "photons";
  for (const auto& [name, bytes] : test::fuzzCorpus()) {
    const std::string path = (folder / name).string();
    if (std::getenv("BRUME_WRITE_CORPUS")) {
      AtomicFile output(path);
      output.write(bytes.data(), bytes.size());
      output.commit();
    }
    EXPECT_EQ(readFileBytes(path, 1 << 20), bytes) << path;
  }
}

}  // namespace
}  // namespace brume
