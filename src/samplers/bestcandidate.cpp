// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/best_candidate.h"
#include "core/lowdiscrepancy.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Where the pattern lies on the image.
struct Tiling {
  double width = 32;  ///< of a tile [pixels]
  Vec2d origin{0};    ///< of tile (0, 0) [pixels]
};

class PixelStream final : public ScrambledSequence {
 public:
  PixelStream(std::uint64_t seed, const Tiling& tiling, const BestCandidatePattern& pattern)
      : seed_(seed), tiling_(tiling), pattern_(pattern) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    setPixelKey(hashIntegers(seed_, pixel.x, pixel.y));
    points_.clear();
    const Vec2i first = tileOf(pixel), last = tileOf(pixel + Vec2i(1));
    for (int ty = first.y; ty <= last.y; ++ty)
      for (int tx = first.x; tx <= last.x; ++tx) gatherFromTile({tx, ty});
    // In random order, so that the first few of them cover the pixel too.
    Rng order(hashIntegers(pixelKey(), 0x6f72646572));
    for (std::size_t i = points_.size(); i > 1; --i)
      std::swap(points_[i - 1], points_[order.below(static_cast<std::uint32_t>(i))]);
    // A pixel without a point would stay black: it gets one.
    if (points_.empty()) {
      Rng rng(mixBits(pixelKey()));
      points_.push_back({rng.uniform2(), rng.uniform2(), rng.uniform()});
    }
    return static_cast<int>(points_.size());
  }

  CameraSample startSample(int index) override {
    setSample(static_cast<std::uint32_t>(index));
    const int count = static_cast<int>(points_.size());
    const Point& point = points_[static_cast<std::size_t>(index % count)];
    CameraSample sample;
    if (index < count) {
      sample.raster = positionInPixel(pixel_, point.position);
      sample.lens = point.lens;
      sample.time = point.time;
      return sample;
    }
    // Further rounds move the pixel's points together, each coordinate round its own circle.
    Rng shift(hashIntegers(pixelKey(), index / count));
    sample.raster = positionInPixel(pixel_, moved(point.position, shift.uniform2()));
    sample.lens = moved(point.lens, shift.uniform2());
    sample.time = moved(point.time, shift.uniform());
    return sample;
  }

 private:
  using Point = BestCandidatePattern::Point;

  Vec2i tileOf(Vec2i pixel) const {
    return {static_cast<int>(std::floor((pixel.x - tiling_.origin.x) / tiling_.width)),
            static_cast<int>(std::floor((pixel.y - tiling_.origin.y) / tiling_.width))};
  }
  static float moved(float x, float shift) {
    const float sum = x + shift;
    return sum < 1.f ? sum : sum - 1.f;
  }
  static Vec2 moved(Vec2 p, Vec2 shift) { return {moved(p.x, shift.x), moved(p.y, shift.y)}; }

  /// Adds the points of one tile that fall into the pixel, their positions relative to it. The same
  /// arithmetic serves all pixels, so each point belongs to exactly one.
  void gatherFromTile(Vec2i tile) {
    const Vec2d corner = tiling_.origin + Vec2d(tile) * tiling_.width;
    Rng rng(hashIntegers(seed_, tile.x, tile.y, 0x74696c65));
    const Vec2 lensShift = rng.uniform2();
    const float timeShift = rng.uniform();
    // One cell more on each side than rounding could ask for.
    const auto onTile = [&](double raster, double start, double margin) {
      return static_cast<float>(std::clamp((raster - start) / tiling_.width + margin, 0.0, 1.0));
    };
    constexpr double kMargin = 1e-5;
    const Vec2 lo(onTile(pixel_.x, corner.x, -kMargin), onTile(pixel_.y, corner.y, -kMargin));
    const Vec2 hi(onTile(pixel_.x + 1, corner.x, kMargin), onTile(pixel_.y + 1, corner.y, kMargin));
    const double left = pixel_.x, top = pixel_.y;
    pattern_.forEachNear(lo, hi, [&](const Point& p) {
      const double x = corner.x + static_cast<double>(p.position.x) * tiling_.width;
      const double y = corner.y + static_cast<double>(p.position.y) * tiling_.width;
      if (!(x >= left && x < left + 1 && y >= top && y < top + 1)) return;
      const Vec2 u(std::min(static_cast<float>(x - pixel_.x), kOneMinusEpsilon),
                   std::min(static_cast<float>(y - pixel_.y), kOneMinusEpsilon));
      points_.push_back({u, moved(p.lens, lensShift), moved(p.time, timeShift)});
    });
  }

  std::uint64_t seed_;
  Tiling tiling_;
  const BestCandidatePattern& pattern_;
  Vec2i pixel_{0};
  std::vector<Point> points_;
};

/// A blue-noise pattern of 4096 points repeated over the image, in tiles of 64/sqrt(pixelsamples)
/// pixels; lens positions and times are shifted from tile to tile. Pixels get pixelsamples on
/// average, at least one. The integrators get padded (0,2)-sequences. Source: Mitchell 1991. Test:
/// sampler_test.
class BestCandidateSampler final : public Sampler {
 public:
  struct Params {
    int pixelsamples = 4;

    void visit(ParamVisitor& v) {
      v(pixelsamples, "pixelsamples", kRange, Unit::Samples, "per pixel, on average");
    }
  };

  BestCandidateSampler(const Params& params, const FactoryContext& context)
      : count_(countFor(context, params.pixelsamples, 1)) {
    if (!kRange.contains(count_))
      throw SceneError(context.where,
                       fmt::format("\"bestcandidate\" keeps the points of a pixel in "
                                   "memory: at most {} samples per pixel, not {}",
                                   kRange.hi, count_));
  }

  int samplesPerPixel() const override { return count_; }
  int roundCount(int n) const override { return roundUpToPowerOfTwo(n); }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    // Another seed is another place of the tiles.
    Rng rng(hashIntegers(seed, 0x6f726967));
    Tiling tiling;
    tiling.width = BestCandidatePattern::kGrid / std::sqrt(static_cast<double>(count_));
    const double x = rng.uniformDouble(), y = rng.uniformDouble();
    tiling.origin = Vec2d(x, y) * tiling.width;
    return std::make_unique<PixelStream>(seed, tiling, pattern_);
  }

 private:
  static constexpr Range<int> kRange{1, 1 << 16};

  int count_;
  BestCandidatePattern pattern_;
};

const RegisterPlugin<Sampler, BestCandidateSampler> kRegistration{
    "bestcandidate", Origin::PbrtV2, "blue-noise pattern tiled over the image"};

}  // namespace
}  // namespace brume
