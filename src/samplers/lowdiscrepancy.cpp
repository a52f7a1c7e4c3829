// SPDX-License-Identifier: Apache-2.0
#include "core/lowdiscrepancy.h"

#include <fmt/format.h>

#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Image, lens, time and all integrator dimensions from the shared padded (0,2)-sequences.
class PixelStream final : public ScrambledSequence {
 public:
  PixelStream(std::uint64_t seed, int count) : seed_(seed), count_(count) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    setPixelKey(hashIntegers(seed_, pixel.x, pixel.y));
    return count_;
  }
  CameraSample startSample(int index) override {
    setSample(static_cast<std::uint32_t>(index));
    CameraSample sample;
    sample.raster = positionInPixel(pixel_, get2D());
    sample.lens = get2D();
    sample.time = get1D();
    return sample;
  }

 private:
  std::uint64_t seed_;
  int count_;
  Vec2i pixel_{0};
};

/// Scrambled (0,2)-sequence per pixel and dimension: with 2^k samples every elementary interval of
/// area 2^-k holds exactly one of them. PBRT-v2 scrambles by exclusive or, brume by Owen's method,
/// which converges faster on smooth integrands. Source: Kollig, Keller 2002; Burley 2020. Test:
/// sampler_test.
class LowDiscrepancySampler final : public Sampler {
 public:
  struct Params {
    int pixelsamples = 4;

    void visit(ParamVisitor& v) {
      v(pixelsamples, "pixelsamples", kPixelSamplesRange, Unit::Samples,
        "per pixel, rounded up to a power of two");
    }
  };

  LowDiscrepancySampler(const Params& params, const FactoryContext& context) {
    const int wanted = countFor(context, params.pixelsamples, 1);
    count_ = roundUpToPowerOfTwo(wanted);
    if (count_ != wanted)
      context.log->warning(
          context.where,
          fmt::format("{} samples per pixel are rounded up to {}, a power of two", wanted, count_));
  }

  int samplesPerPixel() const override { return count_; }
  int roundCount(int n) const override { return roundUpToPowerOfTwo(n); }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<PixelStream>(seed, count_);
  }

 private:
  int count_ = 4;
};

const RegisterPlugin<Sampler, LowDiscrepancySampler> kRegistration{
    "lowdiscrepancy", Origin::PbrtV2, "scrambled (0,2)-sequence per pixel"};

}  // namespace
}  // namespace brume
