// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/volume.h"
#include "volumes/phase_functions.h"

namespace brume {

/// The parameters that all volumes share.
struct VolumeParams {
  Rgb sigma_a, sigma_s, Le;
  Vec3 p0{0}, p1{1};
  PhaseParams phase;
  void visit(ParamVisitor& v);
};

/// A ray in volume space. Its direction is not normalised: t is the world length.
struct LocalRay {
  Vec3d o, d;
};

struct IntervalD {
  double t0 = 0, t1 = 0;
};

/// A medium in a box of volume space whose coefficients are constants times one scalar density >=
/// 0. All integrals along a ray reduce to D = Int density dt: tau = sigma_t D, and the emission is
/// Le (1 - exp(-sigma_t D)) / sigma_t. Geometry is done in double, so that rays through faces,
/// edges and corners meet what they should.
class BoxVolume : public Volume {
 public:
  BoxVolume(const VolumeParams& params, const FactoryContext& context);

  Bounds3 bounds() const final;
  void appendBoxes(std::vector<MediumBox>& boxes) const final;
  std::optional<Interval> intersect(const Ray& ray) const final;
  MediumCoefficients at(const Vec3& p) const final;
  Rgb majorant() const final;
  Rgb opticalDepth(const Ray& ray, Interval range) const override;
  std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                          float depth) const override;
  Rgb emission(const Ray& ray, Interval range) const final;
  Rgb totalEmission() const final {
    return isEmissive() ? unit_.Le * static_cast<float>(worldIntegral()) : Rgb();
  }
  Vec3 sampleEmission(Rng& rng) const final;
  void appendPieces(const Ray& ray, Interval range,
                    std::vector<MediumPiece>& pieces) const override;
  bool isClosedForm() const override { return true; }
  bool isEmissive() const final { return !unit_.Le.isBlack() && maxDensity() > 0; }
  bool isScattering() const final { return !unit_.sigma_s.isBlack() && maxDensity() > 0; }
  Rgb phase(const Vec3&, const Vec3& wo, const Vec3& wi) const final {
    return Rgb(phase_->p(wo, wi));
  }
  ScatterSample samplePhase(const Vec3&, const Vec3& wo, const Rgb&, float uComponent,
                            Vec2 u) const final {
    const PhaseSample s = phase_->sample(wo, uComponent, u);
    return {s.wi, Rgb(s.value), s.pdf};
  }
  float phasePeak() const final { return phase_->peak(); }
  std::optional<float> henyeyGreenstein() const final { return phase_->henyeyGreenstein(); }
  const MediumCoefficients* proportions() const final { return isTracked() ? nullptr : &unit_; }
  std::optional<UniformMedium> uniform() const final {
    const auto g = phase_->henyeyGreenstein();
    return isConstant() && g ? std::optional(UniformMedium{unit_, *g}) : std::nullopt;
  }

 protected:
  // All in volume space; points and intervals lie inside the box.
  virtual double density(const Vec3d& p) const = 0;
  virtual double maxDensity() const = 0;
  /// Whether the density is 1 in all of the box.
  virtual bool isConstant() const { return false; }
  virtual double integral(const LocalRay& ray, IntervalD range) const = 0;
  /// The t with Int_range.t0^t density = target > 0; none when the range holds less.
  virtual std::optional<double> invert(const LocalRay& ray, IntervalD range,
                                       double target) const = 0;
  /// Pieces with t0, t1, form and c; the caller adds the rest.
  virtual void appendDensity(const LocalRay& ray, IntervalD range,
                             std::vector<MediumPiece>& pieces) const = 0;
  /// Int density over the box, asked for of emissive media only; and a point drawn from it.
  virtual double totalDensity() const = 0;
  virtual Vec3d sampleDensity(Rng& rng) const = 0;
  /// range without empty ends; none when all of it is empty.
  virtual std::optional<IntervalD> tighten(const LocalRay&, IntervalD range) const { return range; }

  /// For the ends of constructors. Throws SceneError for coefficients that floats cannot work with.
  void checkCoefficients(const FactoryContext& context) const;
  const Vec3d& boxLo() const { return lo_; }
  const Vec3d& boxHi() const { return hi_; }
  /// At density 1.
  const MediumCoefficients& unit() const { return unit_; }
  LocalRay toLocal(const Ray& ray) const;
  std::optional<IntervalD> clip(const LocalRay& ray, Interval range) const;

 private:
  /// Int density over the region of render space.
  double worldIntegral() const;

  Transform volumeToWorld_;
  Vec3d lo_, hi_;
  bool isFlat_ = false;
  MediumCoefficients unit_;  // at density 1
  std::unique_ptr<PhaseFunction> phase_;
};

}  // namespace brume
