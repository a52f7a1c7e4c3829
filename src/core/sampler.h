// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/math.h"
#include "core/params.h"
#include "core/rgb.h"

namespace brume {

/// Range of the numbers of samples per pixel that samplers declare.
inline constexpr Range<int> kPixelSamplesRange{1, 1 << 24};

/// Where and when one camera ray starts.
struct CameraSample {
  Vec2 raster{0};  ///< continuous raster space: pixel (x, y) covers [x, x+1) x [y, y+1), y down
  Vec2 lens{0};    ///< unit square
  float time = 0;  ///< unit interval, mapped to the shutter by the camera
};

/// The random dimensions of one camera path, in the order in which they are asked for. All values
/// lie in [0, 1).
class SampleStream {
 public:
  virtual ~SampleStream() = default;
  virtual float get1D() = 0;
  virtual Vec2 get2D() = 0;
  /// A value that shifts a rule of evenly spaced points: where the sampler can, 2^k samples of a
  /// pixel get evenly spaced values with one random offset, so that their rules together are one
  /// finer rule.
  virtual float getShift() { return get1D(); }
  /// A set of values that is well distributed in itself and over the samples of the pixel.
  virtual void get1DArray(std::span<float> values) = 0;
  virtual void get2DArray(std::span<Vec2> values) = 0;
};

/// The camera samples of one pixel after another; one object per thread. What it yields depends on
/// (seed, pixel, index) only.
class PixelSampler : public SampleStream {
 public:
  /// Moves to a pixel. Returns the number of its samples in the first round of samplesPerPixel
  /// (bestcandidate: differs per pixel; further rounds have samplesPerPixel).
  virtual int startPixel(Vec2i pixel) = 0;
  /// Moves to a sample of this pixel; index may exceed the number given by startPixel: the sequence
  /// goes on.
  virtual CameraSample startSample(int index) = 0;
  /// After the samples [0, n) of a pixel: the number of samples to take instead of them, all anew,
  /// or 0 to keep them (adaptive).
  virtual int refine(std::span<const Rgb>) { return 0; }
};

/// A sampling pattern over the image. Immutable and thread-safe.
class Sampler {
 public:
  static constexpr std::string_view kPluginKind = "Sampler";
  struct FactoryContext {
    Bounds2i pixels;     ///< all pixels that get samples (the crop window grown by the filter)
    bool quick = false;  ///< --quick
    std::optional<int> samplesPerPixel;  ///< --spp: wins over the scene and --quick (see countFor)
    SourceLocation where;
    Log* log = nullptr;
  };

  virtual ~Sampler() = default;
  /// Average number of samples per pixel.
  virtual int samplesPerPixel() const = 0;
  /// The count >= n that this pattern distributes best (powers of two for (0,2)-sequences).
  virtual int roundCount(int n) const { return n; }
  /// Whether refine() may ask for more, so that a pixel must be finished in one go.
  virtual bool isAdaptive() const { return false; }
  virtual std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const = 0;

 protected:
  /// Samples per pixel: --spp, else `quick` with --quick, else what the scene says. Throws
  /// SceneError when --spp is out of range.
  static int countFor(const FactoryContext& context, int fromScene, int quick);
};

}  // namespace brume
