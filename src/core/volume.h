// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "core/math.h"
#include "core/params.h"
#include "core/phase.h"
#include "core/ray.h"
#include "core/rgb.h"
#include "core/rng.h"
#include "core/transform.h"

namespace brume {

/// Coefficients of a medium at a point. Lengths are world lengths.
struct MediumCoefficients {
  Rgb sigma_a, sigma_s;  ///< absorption and scattering [1/length]
  Rgb Le;  ///< radiance added per unit length (PBRT-v2's meaning: not multiplied by sigma_a)
  Rgb sigma_t() const { return sigma_a + sigma_s; }

  MediumCoefficients& operator+=(const MediumCoefficients& o) {
    sigma_a += o.sigma_a;
    sigma_s += o.sigma_s;
    Le += o.Le;
    return *this;
  }
  friend MediumCoefficients operator*(const MediumCoefficients& c, float s) {
    return {c.sigma_a * s, c.sigma_s * s, c.Le * s};
  }
};

/// A direction in which light scatters at a point of a medium.
struct ScatterSample {
  Vec3 wi{0};     ///< unit, from the point towards where the light comes from
  Rgb value;      ///< phase function of each channel [1/sr]
  float pdf = 0;  ///< per solid angle
};

/// Density of Volume::samplePhase in a direction where Volume::phase has this value.
inline float phasePdf(const Rgb& value, const Rgb& carried) {
  const float sum = carried.r + carried.g + carried.b;
  return sum > 0 ? (carried.r * value.r + carried.g * value.g + carried.b * value.b) / sum
                 : value.average();
}

/// Part of a phase function at a point: weight times a Henyey-Greenstein function of g.
struct PhaseLobe {
  float g = 0;
  Rgb weight{1.f};  ///< in each channel
};

class Volume;

/// A stretch of a ray on which a medium is `unit` times one scalar density: known in closed form,
/// or tracked.
struct MediumPiece {
  enum class Form {
    Exponential,  ///< c[0] exp(-k (t - e)), k = c[1], e the denser end: t0 for k >= 0, else t1
    Cubic,   ///< sum of c[i] times the Bernstein polynomial i of degree 3 over [t0, t1], c >= 0
    Tracked  ///< nothing but one tentative collision at t0, see Volume::isTracked(): c[i] is the
             ///< optical depth of channel i behind it; the density is Volume::densityAt()
  };
  Form form = Form::Exponential;
  double t0 = 0, t1 = 0;
  std::array<double, 4> c{};
  const MediumCoefficients* unit = nullptr;
  const Volume* tracked = nullptr;  ///< of this form: where the density comes from

  /// Both 0 for tracked pieces, of which only the tentative collision counts.
  double density(double t) const;
  /// Int_a^b density dt for t0 <= a <= b <= t1, exact to rounding and never negative.
  double integral(double a, double b) const;
};

/// A medium that is the same everywhere inside its volume, with a Henyey-Greenstein phase function.
struct UniformMedium {
  MediumCoefficients coefficients;
  float g = 0;  ///< 0: isotropic
};

/// A box of render space: p is inside where dot(normal, p) <= offset for all faces, those of one
/// axis side by side. Normals are unit vectors to the outside.
struct MediumBox {
  std::array<Vec3d, 6> normal;
  std::array<double, 6> offset;
};

/// A participating medium in a region of render space. Immutable and thread-safe. Everything that
/// can be computed exactly is. Rays are parametrised by t with a normalised direction, so t is a
/// length; intervals must lie inside the ray, they may reach beyond the medium.
class Volume {
 public:
  static constexpr std::string_view kPluginKind = "Volume";
  struct FactoryContext {
    Transform volumeToWorld;  ///< CTM shifted to render space
    SourceLocation where;
    Log* log = nullptr;
  };
  virtual ~Volume() = default;

  virtual Bounds3 bounds() const = 0;
  /// Appends the boxes that end media, where their ends are those of boxes.
  virtual void appendBoxes(std::vector<MediumBox>& /*boxes*/) const {}
  /// The part of (0, ray.tMax) that may hold medium; none when the ray misses. Empty ends are cut
  /// off as far as that is cheap.
  virtual std::optional<Interval> intersect(const Ray& ray) const = 0;
  /// All zero outside.
  virtual MediumCoefficients at(const Vec3& p) const = 0;
  /// No sigma_t in the region is larger.
  virtual Rgb majorant() const = 0;

  /// Int_t0^t1 sigma_t(ray(t)) dt per channel.
  virtual Rgb opticalDepth(const Ray& ray, Interval range) const = 0;
  Rgb transmittance(const Ray& ray, Interval range) const { return exp(-opticalDepth(ray, range)); }
  /// Of the whole ray (0, ray.tMax).
  Rgb transmittance(const Ray& ray) const {
    const auto range = intersect(ray);
    return range ? transmittance(ray, *range) : Rgb(1.f);
  }
  /// The t in range with Int_t0^t sigma_t[channel] = depth; none when the whole range holds less.
  virtual std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                                  float depth) const = 0;
  /// Int_t0^t1 exp(-tau(t0, t)) Le(ray(t)) dt, tau of this volume alone.
  virtual Rgb emission(const Ray& ray, Interval range) const = 0;
  /// Int Le dV over the region [W/sr], attenuation ignored.
  virtual Rgb totalEmission() const = 0;
  /// A point with the density Le(p) / totalEmission(), of the luminances, per world volume.
  /// Requires isEmissive().
  virtual Vec3 sampleEmission(Rng& rng) const = 0;
  /// Appends the medium inside range as pieces, empty parts left out. Those of one region come in
  /// order and do not overlap; a sum of volumes appends those of one after those of the other.
  virtual void appendPieces(const Ray& ray, Interval range,
                            std::vector<MediumPiece>& pieces) const = 0;
  /// opticalDepth() takes a few operations wherever the ray goes.
  virtual bool isClosedForm() const = 0;
  virtual bool isEmissive() const = 0;
  virtual bool isScattering() const = 0;
  /// The density has no integral in closed form. What stands for it along a ray is then a Poisson
  /// process of tentative collisions t_i with a majorant mu(t) for its rate, drawn anew for every
  /// ray: Tr(t) is estimated by prod_{t_i < t} (1 - sigma_t(t_i) / mu(t_i)), without bias (ratio
  /// tracking), opticalDepth() is minus its logarithm, and where a free flight of one depth ends by
  /// that estimate it ends by delta tracking. Unbiased: all that is linear in Tr(t), and all
  /// decisions that know nothing of what the process does behind t.
  virtual bool isTracked() const { return false; }
  /// Density of a tracked medium at ray(t).
  virtual double densityAt(const Ray&, double) const { return 0; }
  /// All coefficients at all points are these times one scalar density; null: they are not, or the
  /// density is tracked.
  virtual const MediumCoefficients* proportions() const { return nullptr; }
  /// Set for media that special kernels can take.
  virtual std::optional<UniformMedium> uniform() const { return std::nullopt; }
  /// g of the one Henyey-Greenstein phase function of all points and channels (0: isotropic); none:
  /// it is another one.
  virtual std::optional<float> henyeyGreenstein() const { return std::nullopt; }
  /// Appends Henyey-Greenstein lobes whose sum is the phase function at p; false, and nothing, when
  /// it is another one. The answer's kind is the same at all points.
  virtual bool appendLobes(const Vec3&, std::vector<PhaseLobe>& lobes) const {
    const auto g = henyeyGreenstein();
    if (g) lobes.push_back({*g, Rgb(1.f)});
    return g.has_value();
  }

  /// Phase function at p for each channel [1/sr]. Where volumes overlap it is the mean weighted by
  /// the channel's sigma_s, so that sigma_s * phase is the sum of what each of them scatters. Each
  /// channel is normalised, but at points (channels) without scattering it has no meaning.
  virtual Rgb phase(const Vec3& p, const Vec3& wo, const Vec3& wi) const = 0;
  /// A direction with the density phasePdf(phase(p, wo, wi), carried). `carried` >= 0: what a path
  /// carries in each channel, sigma_s included; the sum of carried * value / pdf is that of
  /// carried.
  virtual ScatterSample samplePhase(const Vec3& p, const Vec3& wo, const Rgb& carried,
                                    float uComponent, Vec2 u) const = 0;
  /// No phase function value in the region is larger [1/sr].
  virtual float phasePeak() const = 0;
};

/// The sum of several volumes.
std::unique_ptr<Volume> makeAggregateVolume(std::vector<const Volume*> volumes);

}  // namespace brume
