// SPDX-License-Identifier: Apache-2.0
#include "transport/photon_file.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>

#include "core/error.h"
#include "core/io/crc32.h"
#include "core/io/input_file.h"

namespace brume {
namespace {

// The first byte is no text, and the line ends show a transfer as text.
constexpr std::array<unsigned char, 8> kMagic = {0x89, 'B', 'P', 'H', '\r', '\n', 0x1a, '\n'};
constexpr std::uint32_t kByteOrder = 0x01020304, kByteOrderSwapped = 0x04030201;
constexpr std::size_t kHeaderBytes = 256, kPhotonBytes = 32, kTrailerBytes = 4;
constexpr std::size_t kUnitsBytes = 56, kReservedBytes = 16;
constexpr std::string_view kUnits = "position: scene unit; power: W, linear Rec. 709";
static_assert(kUnits.size() <= kUnitsBytes);
/// Photons that are encoded at once.
constexpr std::size_t kPiece = 1 << 12;

/// Photons that an index can name; kd-trees need some room.
constexpr std::uint64_t kMaxPhotons = (std::uint64_t{1} << 32) - 64;

/// Little-endian numbers, one after the other.
class Encoder {
 public:
  void put32(std::uint32_t v) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<unsigned char>(v >> shift));
  }
  void put64(std::uint64_t v) {
    put32(static_cast<std::uint32_t>(v));
    put32(static_cast<std::uint32_t>(v >> 32));
  }
  void put(float v) { put32(std::bit_cast<std::uint32_t>(v)); }
  void put(double v) { put64(std::bit_cast<std::uint64_t>(v)); }
  void put(const Vec3& v) { put(v.x), put(v.y), put(v.z); }
  void put(const Vec3d& v) { put(v.x), put(v.y), put(v.z); }
  void put(const Photon& photon) {
    put(photon.p);
    put(photon.power.r), put(photon.power.g), put(photon.power.b);
    put32(photon.wi.bits());
    put32(photon.bits);
  }
  Bytes bytes;
};

class Decoder {
 public:
  explicit Decoder(ByteSpan bytes) : bytes_(bytes) {}
  ByteSpan get(std::size_t count) {
    const ByteSpan part = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return part;
  }
  std::uint32_t get32() {
    const ByteSpan b = get(4);
    return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
  }
  std::uint64_t get64() {
    const std::uint64_t low = get32();
    return low | std::uint64_t{get32()} << 32;
  }
  float getFloat() { return std::bit_cast<float>(get32()); }
  double getDouble() { return std::bit_cast<double>(get64()); }
  // The order of evaluation within braces is that of writing.
  Vec3 getVec3() { return Vec3{getFloat(), getFloat(), getFloat()}; }
  Vec3d getVec3d() { return Vec3d{getDouble(), getDouble(), getDouble()}; }
  Photon getPhoton() {
    Photon photon;
    photon.p = getVec3();
    photon.power = Rgb{getFloat(), getFloat(), getFloat()};
    photon.wi = PackedDirection::fromBits(get32());
    photon.bits = get32();
    return photon;
  }

 private:
  ByteSpan bytes_;
};

PathsPerClass countClasses(const std::vector<Photon>& photons) {
  PathsPerClass counts{};
  for (const Photon& photon : photons) ++counts[static_cast<std::size_t>(photon.photonClass())];
  return counts;
}

Bounds3 boundsOf(const std::vector<Photon>& photons) {
  if (photons.empty()) return {Vec3(0), Vec3(0)};
  Bounds3 bounds;
  for (const Photon& photon : photons) bounds.extend(photon.p);
  return bounds;
}

Bytes encodeHeader(const PhotonFile& file) {
  const std::vector<Photon>& photons = file.set.photons;
  Encoder e;
  e.bytes.assign(kMagic.begin(), kMagic.end());
  e.put32(kByteOrder);
  e.put32(PhotonFile::kVersion);
  e.put32(kHeaderBytes);
  e.put32(kPhotonBytes);
  e.put64(photons.size());
  for (const std::uint64_t n : file.set.paths) e.put64(n);
  for (const std::uint64_t n : countClasses(photons)) e.put64(n);
  e.put(file.origin);
  const Bounds3 bounds = boundsOf(photons);
  e.put(bounds.lo);
  e.put(bounds.hi);
  e.put64(file.seed);
  e.bytes.insert(e.bytes.end(), kUnits.begin(), kUnits.end());
  e.bytes.resize(kHeaderBytes, 0);
  return std::move(e.bytes);
}

/// The header's numbers.
struct Header {
  std::uint64_t photons = 0, seed = 0;
  PathsPerClass paths{}, counts{};
  Vec3d origin{0};
  Bounds3 bounds;
};

/// Reads and checks one file.
class Reader {
 public:
  Reader(ByteSpan bytes, const std::string& name) : bytes_(bytes), name_(name) {}
  PhotonFile read();

 private:
  template <class... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
    throw SceneError(
        fmt::format("'{}' {}", name_, fmt::format(format, std::forward<Args>(args)...)));
  }
  void checkKind(Decoder& decoder) const;
  void checkSize(std::uint64_t photons) const;
  Header readHeader(Decoder& decoder) const;
  void checkContents(const Header& header, const std::vector<Photon>& photons) const;

  ByteSpan bytes_;
  const std::string& name_;
};

/// Magic number, byte order, version and sizes.
void Reader::checkKind(Decoder& decoder) const {
  const std::size_t n = std::min(bytes_.size(), kMagic.size());
  if (n == 0 ||
      !std::equal(kMagic.begin(), kMagic.begin() + static_cast<std::ptrdiff_t>(n), bytes_.begin()))
    fail("is not a photon file of brume");
  if (bytes_.size() < kHeaderBytes + kTrailerBytes)
    fail("is truncated: it has {} bytes, the header of a photon file alone {}", bytes_.size(),
         kHeaderBytes);
  decoder.get(kMagic.size());
  const std::uint32_t order = decoder.get32(), version = decoder.get32();
  if (order == kByteOrderSwapped) fail("has its bytes in the wrong order");
  if (order != kByteOrder) fail("is damaged: its mark of the byte order is {:08x}", order);
  if (version != PhotonFile::kVersion)
    fail("is a photon file of version {}; this brume reads version {}", version,
         PhotonFile::kVersion);
  const std::uint32_t headerBytes = decoder.get32(), photonBytes = decoder.get32();
  if (headerBytes != kHeaderBytes || photonBytes != kPhotonBytes)
    fail("is damaged: version 1 has a header of {} and photons of {} bytes, not {} and {}",
         kHeaderBytes, kPhotonBytes, headerBytes, photonBytes);
}

void Reader::checkSize(std::uint64_t photons) const {
  const std::uint64_t room = bytes_.size() - kHeaderBytes - kTrailerBytes;
  if (photons > room / kPhotonBytes)
    fail("is truncated: its header promises {} photons, it has room for {}", photons,
         room / kPhotonBytes);
  if (photons * kPhotonBytes != room)
    fail("is damaged: {} bytes follow the {} photons that its header promises",
         room - photons * kPhotonBytes, photons);
  if (photons > kMaxPhotons)
    fail("holds {} photons; the most that can be used are {}", photons, kMaxPhotons);
}

Header Reader::readHeader(Decoder& decoder) const {
  Header header;
  header.photons = decoder.get64();
  checkSize(header.photons);
  const std::uint32_t expected = Decoder(bytes_.last(kTrailerBytes)).get32();
  const std::uint32_t found = crc32(bytes_.first(bytes_.size() - kTrailerBytes));
  if (found != expected)
    fail("is damaged: the checksum of its contents is {:08x}, it should be {:08x}", found,
         expected);

  for (std::uint64_t& n : header.paths) n = decoder.get64();
  for (std::uint64_t& n : header.counts) n = decoder.get64();
  header.origin = decoder.getVec3d();
  header.bounds.lo = decoder.getVec3();
  header.bounds.hi = decoder.getVec3();
  header.seed = decoder.get64();
  const ByteSpan units = decoder.get(kUnitsBytes);
  std::string expectedUnits(kUnits);
  expectedUnits.resize(kUnitsBytes, '\0');
  if (std::memcmp(units.data(), expectedUnits.data(), kUnitsBytes) != 0)
    fail("has other units than \"{}\"", kUnits);
  for (const unsigned char b : decoder.get(kReservedBytes))
    if (b != 0) fail("is damaged: reserved bytes of its header are not 0");
  return header;
}

/// What no brume writes, though the checksum may be right.
void Reader::checkContents(const Header& header, const std::vector<Photon>& photons) const {
  if (!std::isfinite(header.origin.x) || !std::isfinite(header.origin.y) ||
      !std::isfinite(header.origin.z))
    fail("is damaged: its origin is not finite");
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const Photon& photon = photons[i];
    if (photon.photonClass() >= PhotonClass::Count)
      fail("is damaged: photon {} is of the unknown class {}", i, photon.bits & 0xffu);
    if (!isFinite(photon.p) || !photon.power.isFinite())
      fail("is damaged: position or power of photon {} is not finite", i);
    if (header.paths[static_cast<std::size_t>(photon.photonClass())] == 0)
      fail("is damaged: photon {} is of a class without light paths", i);
  }
  if (countClasses(photons) != header.counts)
    fail("is damaged: its photons are not those that its header counts");
  const Bounds3 bounds = boundsOf(photons);
  // By their bits: -0 is not what was written for 0.
  if (std::memcmp(&bounds, &header.bounds, sizeof bounds) != 0)
    fail("is damaged: its bounds are not those of its photons");
}

PhotonFile Reader::read() {
  Decoder decoder(bytes_);
  checkKind(decoder);
  const Header header = readHeader(decoder);
  PhotonFile file;
  file.origin = header.origin;
  file.seed = header.seed;
  file.set.paths = header.paths;
  file.set.photons.resize(header.photons);
  for (Photon& photon : file.set.photons) photon = decoder.getPhoton();
  checkContents(header, file.set.photons);
  return file;
}

}  // namespace

void PhotonFile::moveTo(const Vec3d& newOrigin) {
  const Vec3d shift = origin - newOrigin;
  if (shift == Vec3d(0)) return;
  for (Photon& photon : set.photons) photon.p = Vec3(Vec3d(photon.p) + shift);
  origin = newOrigin;
}

void encodePhotonFile(const PhotonFile& file, const std::function<void(ByteSpan)>& write) {
  Crc32 crc;
  const auto writeChecked = [&](ByteSpan bytes) {
    crc.add(bytes);
    write(bytes);
  };
  writeChecked(encodeHeader(file));
  const std::span<const Photon> photons(file.set.photons);
  for (std::size_t begin = 0; begin < photons.size(); begin += kPiece) {
    Encoder piece;
    piece.bytes.reserve(kPiece * kPhotonBytes);
    for (const Photon& photon : photons.subspan(begin, std::min(kPiece, photons.size() - begin)))
      piece.put(photon);
    writeChecked(piece.bytes);
  }
  Encoder trailer;
  trailer.put32(crc.value());
  write(trailer.bytes);
}

PhotonFile decodePhotonFile(ByteSpan bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

void writePhotonFile(const std::string& path, const PhotonFile& file) {
  AtomicFile output(path);
  encodePhotonFile(file, [&](ByteSpan bytes) { output.write(bytes.data(), bytes.size()); });
  output.commit();
}

PhotonFile readPhotonFile(const std::string& path) {
  const InputFile input = InputFile::open(path, InputFile::Accept::RegularFiles, {});
  const std::string_view text = input.view();
  return decodePhotonFile({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, path);
}

}  // namespace brume
