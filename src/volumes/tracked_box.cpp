// SPDX-License-Identifier: Apache-2.0
#include "volumes/tracked_box.h"

#include <fmt/format.h>

#include <bit>

#include "core/error.h"
#include "core/medium_along_ray.h"
#include "core/tracking_key.h"

namespace brume {
namespace {

constexpr int kMostCellsPerAxis = 32;
/// Optical depth of the bounds across the box beyond which tracking would not come to an end.
constexpr double kMostDepth = 1e5;
/// Beyond this depth exp(-tau) is below 1e-17; one certain collision counts as kCertain.
constexpr double kOpaqueDepth = 40, kCertain = 1000;

std::uint64_t bitsOf(const Vec3& v, float w) {
  return hashIntegers(std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y),
                      std::bit_cast<std::uint32_t>(v.z), std::bit_cast<std::uint32_t>(w));
}

}  // namespace

void TrackedBox::buildCells(double cellSize, const SourceLocation& where) {
  salt_ = hashIntegers(where.line, where.column);
  for (int a = 0; a < 3; ++a) {
    const double length = boxHi()[a] - boxLo()[a];
    cells_[a] =
        static_cast<int>(std::clamp(std::ceil(length / cellSize), 1.0, double{kMostCellsPerAxis}));
    cellSize_[a] = length / cells_[a];
  }
  bounds_.resize(index({0, 0, cells_[2]}));
  for (int z = 0; z < cells_[2]; ++z)
    for (int y = 0; y < cells_[1]; ++y)
      for (int x = 0; x < cells_[0]; ++x) {
        // Wider by what rounding may do to points and values.
        Bounds3d box = boxOf({x, y, z});
        box.lo -= cellSize_ * 1e-9;
        box.hi += cellSize_ * 1e-9;
        const double bound = upperBound(box) * (1 + 1e-6);
        bounds_[index({x, y, z})] = static_cast<float>(bound);
        maxDensity_ = std::max(maxDensity_, double{static_cast<float>(bound)});
      }
  const Bounds3 box = bounds();
  const double across =
      double{length(box.diagonal())} * maxDensity_ * double{unit().sigma_t().maxChannel()};
  if (!(across <= kMostDepth))
    throw SceneError(where, fmt::format("this medium is too dense to be tracked: its optical depth "
                                        "reaches {:.3g} across its box; at most {:g}",
                                        across, kMostDepth));
}

TrackedBox::Cell TrackedBox::cellOf(const Vec3d& p) const {
  Cell c;
  for (int a = 0; a < 3; ++a)
    c[a] = static_cast<int>(
        std::clamp(std::floor((p[a] - boxLo()[a]) / cellSize_[a]), 0.0, double(cells_[a] - 1)));
  return c;
}

Bounds3d TrackedBox::boxOf(const Cell& c) const {
  const Vec3d lo(c[0], c[1], c[2]);
  return {boxLo() + lo * cellSize_, boxLo() + (lo + Vec3d(1)) * cellSize_};
}

/// The cells along a ray, in order.
struct TrackedBox::Walk {
  Cell cell, step;
  Vec3d next, delta;  ///< t of the next border along each axis, and between two of them

  Walk(const TrackedBox& box, const LocalRay& ray, double t0) {
    const Vec3d start = ray.o + ray.d * t0;
    cell = box.cellOf(start);
    for (int a = 0; a < 3; ++a) {
      step[a] = ray.d[a] > 0 ? 1 : ray.d[a] < 0 ? -1 : 0;
      const double border = box.boxLo()[a] + (cell[a] + (step[a] > 0 ? 1 : 0)) * box.cellSize_[a];
      next[a] = step[a] ? (border - ray.o[a]) / ray.d[a] : std::numeric_limits<double>::infinity();
      delta[a] = step[a] ? box.cellSize_[a] / std::abs(ray.d[a]) : 0;
    }
  }
  int axis() const {
    return next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
  }
};

/// Calls collide(t, ratio) for the tentative collisions in order, ratio = density / bound, until it
/// returns false.
template <class Collision>
void TrackedBox::track(const Ray& ray, Interval range, Collision&& collide) const {
  const LocalRay local = toLocal(ray);
  const auto clipped = clip(local, range);
  const double sigma_t = double{unit().sigma_t().maxChannel()};
  if (!clipped || sigma_t == 0 || maxDensity_ == 0) return;

  Rng rng(hashIntegers(bitsOf(ray.o, ray.time), bitsOf(ray.d, ray.tMax), trackingKey(), salt_));
  const auto exponential = [&] { return -std::log1p(-rng.uniformDouble()); };
  Walk walk(*this, local, clipped->t0);
  double t = clipped->t0, depth = exponential();
  while (t < clipped->t1) {
    const int axis = walk.axis();
    const double end = std::min(std::max(walk.next[axis], t), clipped->t1);
    const double bound = double{bounds_[index(walk.cell)]}, mu = bound * sigma_t;
    while (depth < mu * (end - t)) {
      t += depth / mu;
      depth = exponential();
      // On a float, so that who asks for the depth in front of the collision gets that.
      const float rounded = std::clamp(static_cast<float>(t), static_cast<float>(clipped->t0),
                                       std::nextafter(static_cast<float>(clipped->t1), 0.f));
      const Bounds3d box = boxOf(walk.cell);
      const double here = density(max(box.lo, min(box.hi, local.o + local.d * double{rounded})));
      BRUME_CHECK(here <= bound);
      if (here > 0 && !collide(rounded, here / bound)) return;
    }
    depth -= mu * (end - t);
    t = end;
    walk.cell[axis] += walk.step[axis];
    if (walk.cell[axis] < 0 || walk.cell[axis] >= cells_[axis]) return;
    walk.next[axis] += walk.delta[axis];
  }
}

void TrackedBox::appendPieces(const Ray& ray, Interval range,
                              std::vector<MediumPiece>& pieces) const {
  const auto clipped = clip(toLocal(ray), range);
  if (!clipped) return;
  const Rgb sigma_t = unit().sigma_t();
  const double largest = double{sigma_t.maxChannel()};
  std::array<double, 3> depth{};
  MediumPiece last{MediumPiece::Form::Tracked, clipped->t0, clipped->t1, {}, &unit(), this};
  track(ray, range, [&](float t, double ratio) {
    if (double{t} > last.t0) {
      last.t1 = double{t};
      pieces.push_back(last);
      last.t0 = double{t};
      last.c = {};
    }
    last.t1 = clipped->t1;
    bool isOpaque = true;
    for (int c = 0; c < 3; ++c) {
      const double r = ratio * (double{sigma_t[c]} / largest);
      const double jump = r < 1 ? -std::log1p(-r) : kCertain;
      last.c[static_cast<std::size_t>(c)] += jump;
      depth[static_cast<std::size_t>(c)] += jump;
      isOpaque &= sigma_t[c] == 0 || depth[static_cast<std::size_t>(c)] > kOpaqueDepth;
    }
    return !isOpaque;
  });
  pieces.push_back(last);
}

Rgb TrackedBox::opticalDepth(const Ray& ray, Interval range) const {
  const Rgb sigma_t = unit().sigma_t();
  const float largest = sigma_t.maxChannel();
  Vec3d Tr(1);
  track(ray, range, [&](float, double ratio) {
    for (int c = 0; c < 3; ++c) Tr[c] *= std::max(0.0, 1 - ratio * double{sigma_t[c] / largest});
    return std::max({Tr.x, Tr.y, Tr.z}) > 0;
  });
  Rgb depth;
  for (int c = 0; c < 3; ++c) depth[c] = static_cast<float>(std::min(-std::log(Tr[c]), kCertain));
  return depth;
}

std::optional<float> TrackedBox::invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                                    float depth) const {
  const auto t = MediumAlongRay(*this, ray, range).invert(channel, double{depth});
  return t ? std::optional(static_cast<float>(*t)) : std::nullopt;
}

double TrackedBox::densityAt(const Ray& ray, double t) const {
  const LocalRay local = toLocal(ray);
  return density(max(boxLo(), min(boxHi(), local.o + local.d * t)));
}

// Of media in closed form only.
double TrackedBox::integral(const LocalRay&, IntervalD) const { throw InternalError("tracked"); }
std::optional<double> TrackedBox::invert(const LocalRay&, IntervalD, double) const {
  throw InternalError("tracked");
}
void TrackedBox::appendDensity(const LocalRay&, IntervalD, std::vector<MediumPiece>&) const {
  throw InternalError("tracked");
}
// Of emitting media only.
double TrackedBox::totalDensity() const { throw InternalError("tracked"); }
Vec3d TrackedBox::sampleDensity(Rng&) const { throw InternalError("tracked"); }

}  // namespace brume
