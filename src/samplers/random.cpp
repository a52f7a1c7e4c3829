// SPDX-License-Identifier: Apache-2.0
#include "core/lowdiscrepancy.h"
#include "core/registry.h"

namespace brume {
namespace {

class PixelStream final : public PixelSampler {
 public:
  PixelStream(std::uint64_t seed, int count) : seed_(seed), count_(count) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    key_ = hashIntegers(seed_, pixel.x, pixel.y);
    return count_;
  }
  CameraSample startSample(int index) override {
    rng_ = Rng(hashIntegers(key_, index));
    CameraSample sample;
    sample.raster = positionInPixel(pixel_, rng_.uniform2());
    sample.lens = rng_.uniform2();
    sample.time = rng_.uniform();
    return sample;
  }
  float get1D() override { return rng_.uniform(); }
  Vec2 get2D() override { return rng_.uniform2(); }
  void get1DArray(std::span<float> values) override {
    for (float& v : values) v = rng_.uniform();
  }
  void get2DArray(std::span<Vec2> values) override {
    for (Vec2& v : values) v = rng_.uniform2();
  }

 private:
  std::uint64_t seed_, key_ = 0;
  int count_;
  Vec2i pixel_{0};
  Rng rng_;
};

/// Independent uniform random numbers: the yardstick for the other samplers. Variance falls as
/// 1/pixelsamples. Takes pixelsamples with --quick too, as PBRT-v2's. Test: sampler_test.
class RandomSampler final : public Sampler {
 public:
  struct Params {
    int pixelsamples = 4;

    void visit(ParamVisitor& v) {
      v(pixelsamples, "pixelsamples", kPixelSamplesRange, Unit::Samples, "per pixel");
    }
  };

  RandomSampler(const Params& params, const FactoryContext& context)
      : count_(countFor(context, params.pixelsamples, params.pixelsamples)) {}

  int samplesPerPixel() const override { return count_; }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<PixelStream>(seed, count_);
  }

 private:
  int count_;
};

const RegisterPlugin<Sampler, RandomSampler> kRegistration{"random", Origin::PbrtV2,
                                                           "independent random samples"};

}  // namespace
}  // namespace brume
