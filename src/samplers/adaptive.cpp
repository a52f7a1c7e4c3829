// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/log.h"
#include "core/lowdiscrepancy.h"
#include "core/registry.h"

namespace brume {
namespace {

struct Counts {
  int min = 4, max = 32;
};

/// Whether a sample differs from the pixel's mean by more than half of it. A black pixel has no
/// contrast.
bool hasContrast(std::span<const Rgb> L) {
  constexpr double kMaxContrast = 0.5;
  double mean = 0;
  for (const Rgb& l : L) mean += static_cast<double>(l.luminance()) / static_cast<double>(L.size());
  for (const Rgb& l : L)
    if (std::abs(static_cast<double>(l.luminance()) - mean) > kMaxContrast * mean) return true;
  return false;
}

class PixelStream final : public ScrambledSequence {
 public:
  PixelStream(std::uint64_t seed, Counts counts) : seed_(seed), counts_(counts) {}

  int startPixel(Vec2i pixel) override {
    pixel_ = pixel;
    setPixelKey(hashIntegers(seed_, pixel.x, pixel.y));
    isRefined_ = false;
    return counts_.min;
  }
  CameraSample startSample(int index) override {
    setSample(static_cast<std::uint32_t>(index));
    CameraSample sample;
    sample.raster = positionInPixel(pixel_, get2D());
    sample.lens = get2D();
    sample.time = get1D();
    return sample;
  }
  int refine(std::span<const Rgb> L) override {
    if (isRefined_ || !hasContrast(L)) return 0;
    // New random numbers: the old ones led to this decision and would bias the mean.
    isRefined_ = true;
    setPixelKey(mixBits(pixelKey()));
    return counts_.max;
  }

 private:
  std::uint64_t seed_;
  Counts counts_;
  Vec2i pixel_{0};
  bool isRefined_ = false;
};

/// minsamples per pixel; where one of them differs from their mean luminance by more than half of
/// it, they are discarded and maxsamples are taken instead. Samples are those of "lowdiscrepancy".
/// Biased as PBRT-v2's: pixels whose few samples miss a feature stay as they are. Test:
/// sampler_test.
class AdaptiveSampler final : public Sampler {
 public:
  enum class Method { Contrast, ShapeId };
  struct Params {
    int minsamples = 4, maxsamples = 32;
    Method method = Method::Contrast;

    void visit(ParamVisitor& v) {
      v(minsamples, "minsamples", kPixelSamplesRange, Unit::Samples,
        "per pixel at first, rounded up to a power of two, at least 2");
      v(maxsamples, "maxsamples", kPixelSamplesRange, Unit::Samples,
        "per pixel with contrast, rounded up to a power of two, more than minsamples");
      v(method, "method", {{"contrast", Method::Contrast}, {"shapeid", Method::ShapeId}},
        "what makes a pixel take more samples; \"shapeid\" is understood as \"contrast\"");
    }
  };

  AdaptiveSampler(const Params& params, const FactoryContext& context) {
    const auto warn = [&context](const std::string& text) {
      context.log->warning(context.where, text);
    };
    if (params.method == Method::ShapeId)
      warn("\"shapeid\" is not available: the contrast of the samples decides instead");
    int lo = context.quick ? 2 : params.minsamples, hi = countFor(context, params.maxsamples, 4);
    if (context.samplesPerPixel) lo = std::min(lo, hi);
    if (lo > hi) {
      warn(fmt::format("minsamples {} and maxsamples {} are exchanged", lo, hi));
      std::swap(lo, hi);
    }
    counts_ = {std::max(2, roundUpToPowerOfTwo(lo)), roundUpToPowerOfTwo(hi)};
    if (counts_.max <= counts_.min) counts_.max = 2 * counts_.min;
    if (counts_.min != lo || counts_.max != hi)
      warn(
          fmt::format("{} to {} samples per pixel become {} to {}: powers of two, at least 2, "
                      "more at most than at least",
                      lo, hi, counts_.min, counts_.max));
  }

  int samplesPerPixel() const override { return counts_.max; }
  int roundCount(int n) const override { return roundUpToPowerOfTwo(n); }
  bool isAdaptive() const override { return true; }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<PixelStream>(seed, counts_);
  }

 private:
  Counts counts_;
};

const RegisterPlugin<Sampler, AdaptiveSampler> kRegistration{
    "adaptive", Origin::PbrtV2, "few samples, and more in pixels with contrast"};

}  // namespace
}  // namespace brume
