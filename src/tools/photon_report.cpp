// SPDX-License-Identifier: Apache-2.0
#include "tools/photon_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "core/error.h"
#include "core/srgb.h"
#include "transport/photon_file.h"

namespace brume {
namespace {

/// Counts and power of one class of photons.
struct ClassSum {
  std::uint64_t photons = 0;
  double power[3] = {0, 0, 0};  // [W]
};

std::string rowText(PhotonClass c, const ClassSum& sum, std::uint64_t paths) {
  constexpr std::string_view kNames[kPhotonClasses] = {"surface direct",   "surface caustic",
                                                       "surface indirect", "volume unscattered",
                                                       "volume caustic",   "volume multiple"};
  const auto index = static_cast<std::size_t>(c);
  if (paths == 0) return fmt::format("  {:<18} {:>12}\n", kNames[index], "not traced");
  return fmt::format("  {:<18} {:>12} {:>12}   {:.6g} {:.6g} {:.6g}\n", kNames[index], sum.photons,
                     paths, sum.power[0], sum.power[1], sum.power[2]);
}

std::string summary(const PhotonFile& file, const std::string& name) {
  const std::vector<Photon>& photons = file.set.photons;
  std::array<ClassSum, kPhotonClasses> sums{};
  Bounds3 bounds;
  for (const Photon& photon : photons) {
    ClassSum& sum = sums[static_cast<std::size_t>(photon.photonClass())];
    ++sum.photons;
    for (int i = 0; i < 3; ++i) sum.power[i] += static_cast<double>(photon.power[i]);
    bounds.extend(photon.p);
  }
  std::string text = fmt::format("{}: photon file, version {}\n", name, PhotonFile::kVersion);
  text += fmt::format("  {:<18} {:>12}   {}\n", "photons", photons.size(),
                      formatBytes(32.0 * static_cast<double>(photons.size())));
  text += fmt::format("  {:<18} {:>12}\n", "seed", file.seed);
  text += fmt::format("  {:<18} {:g} {:g} {:g}\n", "origin", file.origin.x, file.origin.y,
                      file.origin.z);
  if (!photons.empty()) {
    const Vec3d lo = Vec3d(bounds.lo) + file.origin, hi = Vec3d(bounds.hi) + file.origin;
    text += fmt::format("  {:<18} {:g} {:g} {:g} to {:g} {:g} {:g}\n", "bounds", lo.x, lo.y, lo.z,
                        hi.x, hi.y, hi.z);
  }
  text += fmt::format("\n  {:<18} {:>12} {:>12}   {}\n", "class", "photons", "light paths",
                      "power of all, R G B [W]");
  for (std::size_t c = 0; c < kPhotonClasses; ++c)
    text += rowText(static_cast<PhotonClass>(c), sums[c], file.set.paths[c]);
  return text;
}

/// Power that is shown as white: all but the strongest hundredth of the photons lie below.
float whitePower(const std::vector<Photon>& photons) {
  constexpr double kShownAsTheyAre = 0.99;
  if (photons.empty()) return 1;
  std::vector<float> powers;
  powers.reserve(photons.size());
  for (const Photon& photon : photons) powers.push_back(photon.power.maxChannel());
  const auto at = powers.begin() + static_cast<std::ptrdiff_t>(
                                       kShownAsTheyAre * static_cast<double>(powers.size() - 1));
  std::nth_element(powers.begin(), at, powers.end());
  return *at > 0 ? *at : 1;
}

/// Little-endian bytes, written in pieces.
class PlyBody {
 public:
  explicit PlyBody(AtomicFile& file) : file_(file) {}
  void put(std::uint8_t v) { bytes_.push_back(v); }
  void put(float v) { putBits(std::bit_cast<std::uint32_t>(v), 4); }
  void put(double v) { putBits(std::bit_cast<std::uint64_t>(v), 8); }
  void flush(std::size_t limit) {
    if (bytes_.size() < limit) return;
    file_.write(bytes_.data(), bytes_.size());
    bytes_.clear();
  }

 private:
  void putBits(std::uint64_t bits, int bytes) {
    for (int i = 0; i < bytes; ++i) bytes_.push_back(static_cast<unsigned char>(bits >> (8 * i)));
  }
  AtomicFile& file_;
  Bytes bytes_;
};

void writePly(const std::string& path, const PhotonFile& file) {
  constexpr std::size_t kPiece = 1 << 20;
  const std::vector<Photon>& photons = file.set.photons;
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\n"
      "comment photons of brume: position in scene units, colour by power, class 0 to 5 (surface "
      "direct, caustic, indirect; volume unscattered, caustic, multiple), power in W, direction "
      "to where the light comes from\n"
      "element vertex {}\n"
      "property double x\nproperty double y\nproperty double z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar class\n"
      "property float power_r\nproperty float power_g\nproperty float power_b\n"
      "property float wi_x\nproperty float wi_y\nproperty float wi_z\nend_header\n",
      photons.size());
  AtomicFile output(path);
  output.write(header.data(), header.size());
  const float white = whitePower(photons);
  PlyBody body(output);
  for (const Photon& photon : photons) {
    const Vec3d p = Vec3d(photon.p) + file.origin;
    body.put(p.x), body.put(p.y), body.put(p.z);
    for (int i = 0; i < 3; ++i) body.put(encodeSrgb8(photon.power[i] / white));
    body.put(static_cast<std::uint8_t>(photon.photonClass()));
    for (int i = 0; i < 3; ++i) body.put(photon.power[i]);
    const Vec3 wi = photon.wi.unpack();
    body.put(wi.x), body.put(wi.y), body.put(wi.z);
    body.flush(kPiece);
  }
  body.flush(0);
  output.commit();
}

}  // namespace

std::string reportPhotons(const PhotonReportOptions& options) {
  const PhotonFile file = readPhotonFile(options.file);
  if (!options.ply.empty()) writePly(options.ply, file);
  return summary(file, options.file);
}

}  // namespace brume
