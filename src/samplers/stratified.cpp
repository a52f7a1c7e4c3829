// SPDX-License-Identifier: Apache-2.0
#include "core/lowdiscrepancy.h"
#include "core/registry.h"

namespace brume {
namespace {

/// The strata of one pixel and how they are used.
struct Strata {
  int x = 2, y = 2;
  bool jitter = true;
  std::uint32_t count() const { return static_cast<std::uint32_t>(x * y); }
};

/// One round of x*y samples after another; a round has its own random numbers.
class PixelStream final : public PixelSampler {
 public:
  PixelStream(std::uint64_t seed, const Strata& strata) : seed_(seed), strata_(strata) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    pixelKey_ = hashIntegers(seed_, pixel.x, pixel.y);
    return static_cast<int>(strata_.count());
  }
  CameraSample startSample(int index) override {
    const std::uint32_t n = strata_.count(), round = static_cast<std::uint32_t>(index) / n;
    index_ = static_cast<std::uint32_t>(index) % n;
    roundKey_ = mixBits(pixelKey_ + 0x9e3779b97f4a7c15ull * (round + 1));
    dimension_ = 0;
    CameraSample sample;
    sample.raster = positionInPixel(pixel_, inGrid(index_, nextDimension(), strata_.jitter));
    const Dimension lens = nextDimension(), time = nextDimension();
    sample.lens = inGrid(permutedIndex(index_, n, lens.order), lens, strata_.jitter);
    sample.time =
        inInterval(permutedIndex(index_, n, time.order), n, strata_.jitter ? time.u.x : 0.5f);
    return sample;
  }
  float get1D() override {
    const Dimension d = nextDimension();
    return inInterval(permutedIndex(index_, strata_.count(), d.order), strata_.count(), d.u.x);
  }
  Vec2 get2D() override {
    const Dimension d = nextDimension();
    return inGrid(permutedIndex(index_, strata_.count(), d.order), d, true);
  }
  void get1DArray(std::span<float> values) override {
    const Dimension d = nextDimension();
    const auto m = static_cast<std::uint32_t>(values.size());
    Rng rng(d.sampleKey);
    for (std::uint32_t j = 0; j < m; ++j) values[j] = inSubStratum(j, m, d.order, rng.uniform());
  }
  void get2DArray(std::span<Vec2> values) override {
    const Dimension d = nextDimension();
    const auto m = static_cast<std::uint32_t>(values.size());
    Rng rng(d.sampleKey);
    const std::uint32_t order = rng.bits32();
    // A Latin hypercube: column j meets a random row.
    for (std::uint32_t j = 0; j < m; ++j) {
      const Vec2 u = rng.uniform2();
      values[j] = {inSubStratum(j, m, d.order, u.x),
                   inSubStratum(permutedIndex(j, m, order), m, ~d.order, u.y)};
    }
  }

 private:
  /// The random numbers of one request: `order` is the same for all samples of a round.
  struct Dimension {
    std::uint32_t order;
    std::uint64_t sampleKey;
    Vec2 u;
  };
  Dimension nextDimension() {
    const std::uint64_t h = mixBits(roundKey_ + 0x9e3779b97f4a7c15ull * ++dimension_);
    const std::uint64_t key = h ^ (0xd1b54a32d192ed03ull * (index_ + 1));
    const std::uint64_t bits = mixBits(key);
    return {static_cast<std::uint32_t>(h >> 32),
            bits,
            {uniformFloat(static_cast<std::uint32_t>(bits >> 32)),
             uniformFloat(static_cast<std::uint32_t>(bits))}};
  }
  static float inInterval(std::uint32_t stratum, std::uint32_t n, float u) {
    return std::min((static_cast<float>(stratum) + u) / static_cast<float>(n), kOneMinusEpsilon);
  }
  Vec2 inGrid(std::uint32_t stratum, const Dimension& d, bool jitter) const {
    const auto nx = static_cast<std::uint32_t>(strata_.x),
               ny = static_cast<std::uint32_t>(strata_.y);
    const Vec2 u = jitter ? d.u : Vec2(0.5f);
    return {inInterval(stratum % nx, nx, u.x), inInterval(stratum / nx, ny, u.y)};
  }
  /// Stratum j of m, cut again into one part for each sample of the pixel.
  float inSubStratum(std::uint32_t j, std::uint32_t m, std::uint32_t order, float u) const {
    const std::uint32_t n = strata_.count();
    const auto seed = static_cast<std::uint32_t>(mixBits((std::uint64_t{order} << 32) | j));
    return inInterval(j, m, inInterval(permutedIndex(index_, n, seed), n, u));
  }

  std::uint64_t seed_, pixelKey_ = 0, roundKey_ = 0;
  Strata strata_;
  Vec2i pixel_{0};
  std::uint32_t index_ = 0, dimension_ = 0;
};

/// One sample in each of xsamples * ysamples strata of the pixel, of the lens, of the shutter time
/// and of each integrator dimension, in shuffled orders; arrays are Latin hypercubes that are also
/// stratified over the samples of the pixel. Test: sampler_test.
class StratifiedSampler final : public Sampler {
 public:
  struct Params {
    int xsamples = 2, ysamples = 2;
    bool jitter = true;

    void visit(ParamVisitor& v) {
      constexpr Range<int> kStrataRange{1, 1 << 12};
      v(xsamples, "xsamples", kStrataRange, Unit::Samples, "strata across the pixel");
      v(ysamples, "ysamples", kStrataRange, Unit::Samples, "strata down the pixel");
      v(jitter, "jitter",
        "random positions inside the strata of image, lens and time; false: their centres");
    }
  };

  StratifiedSampler(const Params& params, const FactoryContext& context)
      : strata_{params.xsamples, params.ysamples, params.jitter} {
    if (context.quick) strata_.x = strata_.y = 1;
    if (context.samplesPerPixel) {
      // The most nearly square grid of exactly so many cells.
      const int n = countFor(context, 1, 1);
      strata_.y = 1;
      for (int y = 2; y * y <= n; ++y)
        if (n % y == 0) strata_.y = y;
      strata_.x = n / strata_.y;
    }
  }

  int samplesPerPixel() const override { return static_cast<int>(strata_.count()); }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<PixelStream>(seed, strata_);
  }

 private:
  Strata strata_;
};

const RegisterPlugin<Sampler, StratifiedSampler> kRegistration{
    "stratified", Origin::PbrtV2, "one sample in each cell of a grid over the pixel"};

}  // namespace
}  // namespace brume
