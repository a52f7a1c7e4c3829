// SPDX-License-Identifier: Apache-2.0
#include "core/lowdiscrepancy.h"
#include "core/registry.h"

namespace brume {
namespace {

constexpr std::uint32_t kBases[] = {2, 3, 5, 7, 11};

class PixelStream final : public ScrambledSequence {
 public:
  PixelStream(std::uint64_t seed, int count) : seed_(seed), count_(count) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    const std::uint64_t key = hashIntegers(seed_, pixel.x, pixel.y);
    setPixelKey(key);
    for (std::size_t i = 0; i < std::size(kBases); ++i)
      shifts_[i] = static_cast<std::uint32_t>(hashIntegers(key, i) >> 32);
    return count_;
  }
  CameraSample startSample(int index) override {
    setSample(static_cast<std::uint32_t>(index));
    CameraSample sample;
    sample.raster = positionInPixel(pixel_, {coordinate(0), coordinate(1)});
    sample.lens = {coordinate(2), coordinate(3)};
    sample.time = coordinate(4);
    return sample;
  }

 private:
  float coordinate(std::size_t i) const {
    return shiftedRadicalInverse(kBases[i], sampleIndex(), shifts_[i]);
  }

  std::uint64_t seed_;
  int count_;
  Vec2i pixel_{0};
  std::uint32_t shifts_[std::size(kBases)] = {};
};

/// Halton's sequence per pixel, in bases 2, 3 on the image, 5, 7 on the lens and 11 in time, with
/// random digital shifts from pixel to pixel; the integrators get padded (0,2)-sequences. Any count
/// is well distributed. (PBRT-v2 runs one sequence over each tile.) Source: Halton 1960; Kollig,
/// Keller 2002. Test: sampler_test.
class HaltonSampler final : public Sampler {
 public:
  struct Params {
    int pixelsamples = 4;

    void visit(ParamVisitor& v) {
      v(pixelsamples, "pixelsamples", kPixelSamplesRange, Unit::Samples, "per pixel");
    }
  };

  HaltonSampler(const Params& params, const FactoryContext& context)
      : count_(countFor(context, params.pixelsamples, 1)) {}

  int samplesPerPixel() const override { return count_; }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<PixelStream>(seed, count_);
  }

 private:
  int count_;
};

const RegisterPlugin<Sampler, HaltonSampler> kRegistration{"halton", Origin::PbrtV2,
                                                           "scrambled Halton sequence per pixel"};

}  // namespace
}  // namespace brume
