// SPDX-License-Identifier: Apache-2.0
#include "core/registry.h"
#include "volumes/tracked_box.h"

namespace brume {
namespace {

/// A cloud made of noise, in a box of volume space:
///   density(p) = density min(1, max(0, (e(p) - threshold + wispiness n(frequency p)) / softness))
/// with fractal noise n about in [-1, 1] (FractalNoise), and e = 1 - |s|^2 for shape "ball" (s: p
/// in the box, from -1 to 1 along each axis), e = 1 for shape "box". A larger threshold leaves less
/// of it, a smaller softness makes its borders harder. The noise is computed wherever it is asked
/// for: no grid, no limit to its detail. Collisions and transmittance are tracked (TrackedBox). It
/// does not emit. Test: cloud_test.
class Cloud final : public TrackedBox {
 public:
  enum class Form { Ball, Box };
  struct Params : VolumeParams {
    float density = 1, frequency = 4, gain = 0.5f, wispiness = 1, threshold = 0.5f, softness = 0.5f;
    int octaves = 5, seed = 0;
    Form shape = Form::Ball;

    void visit(ParamVisitor& v) {
      v(sigma_a, "sigma_a", kAnyFloat, Unit::InverseLength,
        "absorption coefficient at density 1, per unit of world length whatever the transform");
      v(sigma_s, "sigma_s", kAnyFloat, Unit::InverseLength,
        "scattering coefficient at density 1, per unit of world length whatever the transform");
      v.point(p0, "p0", Unit::Length, "one corner of the box, in volume space");
      v.point(p1, "p1", Unit::Length, "the opposite corner");
      phase.visit(v);
      v(density, "density", kNonNegative, Unit::None, "the largest density");
      v(frequency, "frequency", kPositive, Unit::InverseLength,
        "coarsest cells of the noise per unit of volume space");
      v(octaves, "octaves", Range<int>{1, 16}, Unit::None,
        "layers of noise, each twice as fine as the one before");
      v(gain, "gain", kUnitInterval, Unit::None, "strength of a layer relative to the one before");
      v(wispiness, "wispiness", kNonNegative, Unit::None,
        "strength of the noise against the shape");
      v(threshold, "threshold", kAnyFloat, Unit::None, "what is less than this is empty");
      v(softness, "softness", kPositive, Unit::None, "how far above that the density is largest");
      v(seed, "seed", kAnyInt, Unit::None, "another number, another cloud");
      v(shape, "shape", {{"ball", Form::Ball}, {"box", Form::Box}},
        "thins out towards the faces of the box, or fills it");
    }
  };

  Cloud(const Params& params, const FactoryContext& context)
      : TrackedBox(params, context),
        params_(params),
        noise_(static_cast<std::uint64_t>(params.seed), params.octaves, double{params.gain}) {
    // The bounds are tight where a cell is small against what the noise does in it.
    constexpr double kCellsPerFeature = 8;
    buildCells(1 / (kCellsPerFeature * double{params.frequency}), context.where);
    checkCoefficients(context);
  }

 protected:
  double density(const Vec3d& p) const override {
    return shaped(envelope(p) +
                  double{params_.wispiness} * noise_.value(p * double{params_.frequency}));
  }
  double upperBound(const Bounds3d& box) const override {
    // The envelope is largest where the box is nearest to the middle.
    const Vec3d middle = (boxLo() + boxHi()) * 0.5, nearest = max(box.lo, min(box.hi, middle));
    const double f = double{params_.frequency};
    if (shaped(envelope(nearest) + double{params_.wispiness} * kLargestNoise) == 0) return 0;
    return shaped(envelope(nearest) +
                  double{params_.wispiness} * noise_.range({box.lo * f, box.hi * f}).hi);
  }

 private:
  double envelope(const Vec3d& p) const {
    if (params_.shape == Form::Box) return 1;
    const Vec3d s = (p * 2.0 - boxLo() - boxHi()) / (boxHi() - boxLo());
    return 1 - dot(s, s);
  }
  /// Grows with its argument.
  double shaped(double v) const {
    return double{params_.density} *
           std::clamp((v - double{params_.threshold}) / double{params_.softness}, 0.0, 1.0);
  }

  Params params_;
  FractalNoise noise_;
};

const RegisterPlugin<Volume, Cloud> kRegistration{
    "cloud", Origin::Brume, "cloud of fractal noise, by delta and ratio tracking"};

}  // namespace
}  // namespace brume
