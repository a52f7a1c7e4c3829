// SPDX-License-Identifier: Apache-2.0
#include "accelerators/beam_raster.h"

#include "core/error.h"
#include "core/parallel.h"

namespace brume {
namespace {

constexpr float kSmallestCosine = 0.17f;  // 80 degrees
constexpr std::uint32_t kBands = 32;      // of rows, each served by one task
/// Added to angles, for the rounding of directions [radians].
constexpr double kAngleSlack = 1e-5;

Vec3 meanDirection(std::span<const Beam> beams) {
  Vec3d sum(0);
  for (const Beam& beam : beams) sum += Vec3d(beam.d);
  const double l = length(sum);
  return l > 0 ? Vec3(sum * (1 / l)) : Vec3(0, 0, 1);
}

double largest(const Vec3& v) { return double{maxComponent(abs(v))}; }

/// The tangents of the directions, in one plane, that meet the disk of radius r around (q, z).
struct Slopes {
  double lo = 1, hi = 0;  // none
};
Slopes slopesOf(double q, double z, double r) {
  const double distance = std::hypot(q, z);
  if (distance <= r) return {-HUGE_VAL, HUGE_VAL};
  const double middle = std::atan2(q, z), half = std::asin(r / distance) + kAngleSlack;
  const double lo = middle - half, hi = middle + half;
  if (lo >= M_PI / 2 || hi <= -M_PI / 2) return {};
  return {lo <= -M_PI / 2 ? -HUGE_VAL : std::tan(lo), hi >= M_PI / 2 ? HUGE_VAL : std::tan(hi)};
}

/// floor of x in [0, count), nearest cell outside; monotone.
std::uint32_t cellOf(double x, std::uint32_t count) {
  if (!(x > 0)) return 0;
  return x >= count ? count - 1 : static_cast<std::uint32_t>(x);
}

}  // namespace

bool RasterBeams::suits(std::span<const Beam> beams) {
  if (beams.empty()) return true;
  const Vec3 middle = meanDirection(beams);
  for (const Beam& beam : beams)
    if (beam.o != beams[0].o || beam.t0 < 0 || dot(beam.d, middle) < kSmallestCosine) return false;
  return true;
}

RasterBeams::RasterBeams(std::span<const Beam> beams) {
  BRUME_CHECK(suits(beams));
  for (const Beam& beam : beams) {
    checkBeam(beam);
    largestRadius_ = std::max(largestRadius_, double{beam.radius});
  }
  begin_.assign(2, 0);
  if (beams.empty()) return;
  origin_ = beams[0].o;
  frame_ = Frame::fromZ(meanDirection(beams));
  buildGrid(beams);
}

std::uint32_t RasterBeams::column(double u) const {
  return cellOf((u - lo_.x) * perUnit_.x, columns_);
}
std::uint32_t RasterBeams::row(double v) const { return cellOf((v - lo_.y) * perUnit_.y, rows_); }

/// As many cells as beams, square on the plane; beams in the order of their cells, then as given.
void RasterBeams::buildGrid(std::span<const Beam> beams) {
  std::vector<Vec2d> at(beams.size());
  Vec2d hi(-HUGE_VAL);
  lo_ = Vec2d(HUGE_VAL);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Vec3d d(frame_.toLocal(beams[i].d));
    at[i] = Vec2d(d.x / d.z, d.y / d.z);
    lo_ = glm::dvec2(std::min(lo_.x, at[i].x), std::min(lo_.y, at[i].y));
    hi = glm::dvec2(std::max(hi.x, at[i].x), std::max(hi.y, at[i].y));
  }
  const double n = static_cast<double>(beams.size());
  const Vec2d size(std::max(hi.x - lo_.x, 1e-9), std::max(hi.y - lo_.y, 1e-9));
  const double cell = std::sqrt(size.x * size.y / n);
  columns_ = static_cast<std::uint32_t>(std::clamp(size.x / cell, 1.0, 16384.0));
  rows_ = static_cast<std::uint32_t>(std::clamp(size.y / cell, 1.0, 16384.0));
  perUnit_ = {columns_ / size.x, rows_ / size.y};

  begin_.assign(std::size_t{columns_} * rows_ + 1, 0);
  const auto cellAt = [&](std::size_t i) {
    return std::size_t{row(at[i].y)} * columns_ + column(at[i].x);
  };
  for (std::size_t i = 0; i < beams.size(); ++i) ++begin_[cellAt(i) + 1];
  for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  beams_.resize(beams.size());
  slotBeams_.resize(beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const std::uint32_t slot = next[cellAt(i)]++;
    beams_[slot] = beams[i];
    slotBeams_[slot] = static_cast<std::uint32_t>(i);
  }
}

RasterBeams::Splat RasterBeams::splatOf(const Vec3& photon) const {
  const Vec3d q = Vec3d(photon) - Vec3d(origin_);
  const double x = dot(q, Vec3d(frame_.x)), y = dot(q, Vec3d(frame_.y)),
               z = dot(q, Vec3d(frame_.z));
  // The rule is computed in float: it may count a photon that lies a little outside.
  const double r = largestRadius_ * (1 + 1e-5) +
                   double{kBeamSlack} * (largest(photon) + largest(origin_) + length(q));
  const Slopes u = slopesOf(x, z, r), v = slopesOf(y, z, r);
  if (u.lo > u.hi || v.lo > v.hi) return {};
  return {column(u.lo), column(u.hi), row(v.lo), row(v.hi)};
}

void RasterBeams::findPairs(const PhotonPositions& photons, Sink sink, void* context) const {
  if (beams_.empty()) return;
  std::vector<Splat> splats(photons.size());
  forEachChunk(static_cast<std::int64_t>(photons.size()), 4096,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i)
                   splats[i] = splatOf(photons[i]);
               });
  forEachChunk(kBands, 1, [&](std::int64_t band, std::int64_t, std::int64_t) {
    const auto first = static_cast<std::uint32_t>(band * rows_ / kBands),
               end = static_cast<std::uint32_t>((band + 1) * rows_ / kBands);
    BeamPairBuffer found(sink, context);
    for (std::size_t i = 0; i < splats.size(); ++i) {
      const Splat& s = splats[i];
      if (s.x0 > s.x1) continue;
      const Vec3 p = photons[i];
      for (std::uint32_t y = std::max(s.y0, first); y <= s.y1 && y < end; ++y) {
        // The cells of a row follow each other, and so do their beams.
        const std::size_t cell = std::size_t{y} * columns_;
        for (std::uint32_t b = begin_[cell + s.x0]; b < begin_[cell + s.x1 + 1]; ++b) {
          const Beam& beam = beams_[b];
          const auto foot = beamFoot(beam.o, beam.d, p);
          if (isInBeam(foot, {beam.t0, beam.t1}, sqr(beam.radius)))
            found.add(b, static_cast<std::uint32_t>(i), foot);
        }
      }
    }
    found.flush();
  });
}

std::size_t RasterBeams::memoryBytes() const {
  return sizeof(*this) + beams_.capacity() * sizeof(Beam) +
         (begin_.capacity() + slotBeams_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace brume
