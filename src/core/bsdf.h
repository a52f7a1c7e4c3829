// SPDX-License-Identifier: Apache-2.0
// Scattering at a surface: lobes in a local frame, summed. Local space: z is the shading normal, x
// along dpdu.
#pragma once

#include <array>
#include <cstddef>
#include <new>
#include <type_traits>

#include "core/math.h"
#include "core/rgb.h"

namespace brume {

/// What a lobe does, as bits; a query names the bits it accepts.
using LobeFlags = std::uint8_t;
inline constexpr LobeFlags kReflection = 1, kTransmission = 2, kDiffuse = 4, kGlossy = 8,
                           kSpecular = 16;
inline constexpr LobeFlags kAllLobes = 31;
inline constexpr LobeFlags kNonSpecular = kReflection | kTransmission | kDiffuse | kGlossy;

struct BsdfSample {
  Rgb f;          ///< [1/sr]; for specular lobes f cos / pdf is the weight, as for all others
  Vec3 wi{0};     ///< unit; local space from a Lobe, render space from a Bsdf
  float pdf = 0;  ///< per solid angle; for specular lobes the probability of the lobe's choice
  LobeFlags flags = 0;
  /// Specular transmission: index of refraction on the side of wo over that on the side of wi. Ray
  /// footprints need it.
  float eta = 1;
  bool isSpecular() const { return flags & kSpecular; }
  bool isTransmission() const { return flags & kTransmission; }
};

/// A scattering function and the density of its sampling for one pair of directions.
struct BsdfValue {
  Rgb f;          ///< [1/sr]
  float pdf = 0;  ///< per solid angle
};

/// One scattering function in the local frame. wo and wi both point away from the surface. Lobes
/// live in a Bsdf's own storage and are never destroyed: they own nothing (trivially destructible,
/// checked by Bsdf::add).
class Lobe {
 public:
  explicit Lobe(LobeFlags flags) : flags_(flags) {}
  LobeFlags flags() const { return flags_; }
  bool matches(LobeFlags accepted) const { return (flags_ & accepted) == flags_; }

  /// [1/sr]; 0 for specular lobes.
  virtual Rgb f(const Vec3& wo, const Vec3& wi) const = 0;
  /// By default cosine-weighted on the side of wo. None: nothing is scattered.
  virtual std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const;
  /// Per solid angle; 0 for specular lobes.
  virtual float pdf(const Vec3& wo, const Vec3& wi) const;
  /// Both at once, for lobes whose f and pdf share work.
  virtual BsdfValue evaluate(const Vec3& wo, const Vec3& wi) const {
    return {f(wo, wi), pdf(wo, wi)};
  }
  /// Whether f is the same for all pairs of directions.
  virtual bool isConstant() const { return false; }
  /// About the share of the light from wo that it scatters, for the choice between lobes where some
  /// are specular.
  virtual float weight(const Vec3& /*wo*/) const { return 1; }

 protected:
  ~Lobe() = default;

 private:
  LobeFlags flags_;
};

inline float cosTheta(const Vec3& w) { return w.z; }
inline float absCosTheta(const Vec3& w) { return std::abs(w.z); }
/// From x and y: 1 - cos^2 would cancel near the pole.
inline float sin2Theta(const Vec3& w) { return w.x * w.x + w.y * w.y; }
inline float sinTheta(const Vec3& w) { return std::sqrt(sin2Theta(w)); }
inline float cosPhi(const Vec3& w) {
  const float s = sinTheta(w);
  return s == 0.f ? 1.f : std::clamp(w.x / s, -1.f, 1.f);
}
inline float sinPhi(const Vec3& w) {
  const float s = sinTheta(w);
  return s == 0.f ? 0.f : std::clamp(w.y / s, -1.f, 1.f);
}
inline bool sameHemisphere(const Vec3& a, const Vec3& b) { return a.z * b.z > 0.f; }

/// The lobes at one surface point, held in place: no allocation.
class Bsdf {
 public:
  static constexpr int kMaxLobes = 8;
  static constexpr std::size_t kLobeBytes = 112;

  Bsdf() = default;
  Bsdf(const Bsdf&) = delete;
  Bsdf& operator=(const Bsdf&) = delete;

  /// Sets the frame: shading normal ns, tangent dpdu (made orthogonal to ns; any where it is 0),
  /// geometric normal ng; and drops all lobes.
  void reset(const Vec3& ns, const Vec3& dpdu, const Vec3& ng);

  /// Adds a lobe of type L, scaled by the present scale. More than kMaxLobes is a BRUME_CHECK
  /// failure.
  template <class L, class... Args>
  void add(Args&&... args) {
    static_assert(std::is_base_of_v<Lobe, L> && sizeof(L) <= kLobeBytes &&
                  std::is_trivially_destructible_v<L>);
    checkRoom();
    new (storage_[static_cast<std::size_t>(count_)].bytes) L(std::forward<Args>(args)...);
    scale_[static_cast<std::size_t>(count_)] = presentScale_;
    hasSpecular_ = hasSpecular_ || lobe(count_).flags() & kSpecular;
    ++count_;
  }
  /// Lobes added from here on are multiplied by s (mix). Returns the scale before.
  Rgb setScale(const Rgb& s) {
    const Rgb before = presentScale_;
    presentScale_ = s;
    return before;
  }
  const Rgb& scale() const { return presentScale_; }

  int lobeCount() const { return count_; }
  int countMatching(LobeFlags accepted) const;
  bool isSpecularOnly() const { return countMatching(kNonSpecular) == 0; }
  const Vec3& shadingNormal() const { return frame_.z; }
  const Vec3& geometricNormal() const { return ng_; }

  /// Sum of the accepted lobes [1/sr]. Whether wi reflects or transmits is decided with the
  /// geometric normal (Veach 5.3).
  Rgb f(const Vec3& wo, const Vec3& wi, LobeFlags accepted = kAllLobes) const;
  /// What f() says of each wi on the side of wo where the accepted lobes are constant and reflect:
  /// then it is 0 on the other side. None: they are not.
  std::optional<Rgb> constantReflection(LobeFlags accepted) const;
  /// Picks one of the matching lobes with uLobe, uniformly, or by their weights where some are
  /// specular (glass reflects by its Fresnel term, and no path through it gains power); pdf is
  /// their mean; f the sum over all non-specular matching ones, or the chosen specular lobe alone.
  std::optional<BsdfSample> sample(const Vec3& wo, float uLobe, Vec2 u,
                                   LobeFlags accepted = kAllLobes) const;
  float pdf(const Vec3& wo, const Vec3& wi, LobeFlags accepted = kAllLobes) const;
  /// f and pdf at once, at little more than the cost of one: what direct light with multiple
  /// importance sampling needs.
  BsdfValue evaluate(const Vec3& wo, const Vec3& wi, LobeFlags accepted = kAllLobes) const;
  /// Hemispherical-directional reflectance of the accepted lobes for wo, by n fixed stratified
  /// samples.
  Rgb reflectance(const Vec3& wo, LobeFlags accepted, int sqrtSamples = 4) const;

  const Frame& frame() const { return frame_; }

 private:
  struct alignas(16) Slot {
    std::byte bytes[kLobeBytes];
  };
  const Lobe& lobe(int i) const {
    return *std::launder(
        reinterpret_cast<const Lobe*>(storage_[static_cast<std::size_t>(i)].bytes));
  }
  void checkRoom() const;
  /// The matching lobes and the probability of each; wo in the local frame.
  struct Choice {
    std::array<int, kMaxLobes> lobes;
    std::array<float, kMaxLobes> probability;
    int count = 0;
  };
  Choice choiceOf(const Vec3& wo, LobeFlags accepted) const;

  Frame frame_;
  Vec3 ng_{0, 0, 1};
  Rgb presentScale_{1.f};
  int count_ = 0;
  bool hasSpecular_ = false;
  std::array<Rgb, kMaxLobes> scale_;
  std::array<Slot, kMaxLobes> storage_;
};

}  // namespace brume
