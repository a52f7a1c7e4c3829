// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>

#include "core/interaction.h"
#include "core/light_bounds.h"
#include "core/params.h"
#include "core/shape.h"

namespace brume {

/// Light arriving at a reference point from one sampled direction.
struct LightSample {
  Rgb L;          ///< incident radiance [W m^-2 sr^-1]; for delta lights radiance * pdf convention:
                  ///< irradiance at normal incidence
  Vec3 wi{0};     ///< unit, from the reference point towards the light
  float pdf = 0;  ///< per solid angle; 1 for delta lights
  float distance = kInfinity;  ///< to the light's point
  /// The point on the light and its error box and normal (area lights), for the end of the shadow
  /// ray; unused at infinity.
  Vec3 p{0}, pError{0}, n{0};
};

/// What light paths are to reach, render space.
struct Ball {
  Vec3 center{0};
  float radius = 0;
};

/// Random numbers for the start of one light path.
struct EmissionUniforms {
  Vec2 point{0}, direction{0};
};

/// The start of a light path.
struct LightEmission {
  Vec3 o{0};  ///< just outside of the light's surface, or outside of the scene
  Vec3 d{0};  ///< unit, the way the light travels
  Rgb power;  ///< alpha = emitted radiance [times cosine] over the density of the choice [W]
};

/// A source of light in render space. Immutable and thread-safe.
class Light {
 public:
  static constexpr std::string_view kPluginKind = "LightSource";
  struct FactoryContext {
    Transform lightToWorld;  ///< CTM shifted to render space
    Vec3d sceneOrigin{0};    ///< scene-space position of the render-space origin
    bool quick = false;      ///< --quick: a quarter of the samples
    SourceLocation where;
    Log* log = nullptr;
  };

  virtual ~Light() = default;

  /// The direction is a delta distribution: cannot be hit, pdfLi is 0.
  virtual bool isDelta() const = 0;
  /// Surrounds the scene: Le answers for rays that leave it.
  virtual bool isInfinite() const { return false; }
  /// Shadow rays per shading point that the scene asks for (directlighting "all").
  virtual int sampleCount() const { return 1; }
  /// Called once, when all geometry is known. Bounds of the scene in render space.
  virtual void setSceneBounds(const Bounds3&) {}

  /// A direction from p towards the light. None when no light can arrive. Visibility is not tested.
  virtual std::optional<LightSample> sampleLi(const Vec3& p, Vec2 u) const = 0;
  /// Density per solid angle of sampleLi for a wi that leaves the scene (infinite lights; 0 for the
  /// others).
  virtual float pdfLi(const Vec3&, const Vec3&) const { return 0; }
  /// Radiance arriving along a ray that leaves the scene.
  virtual Rgb Le(const Ray&) const { return {}; }
  /// Total emitted power [W].
  virtual Rgb power() const = 0;
  /// Starts a light path that may meet the target: for every function g of rays that is 0 on those
  /// which miss it, E[power g(o, d)] is the integral of g over the emitted power. Directions (and
  /// points) are drawn in proportion to the emission as far as that is cheap, or evenly towards the
  /// target where it fills a small part of the directions. None: this sample carries nothing.
  virtual std::optional<LightEmission> sampleEmission(const Ball& target,
                                                      const EmissionUniforms& u) const {
    static_cast<void>(target), static_cast<void>(u);
    return std::nullopt;
  }
  /// About the power that sampleEmission sends out [W], for the choice of a light; 0 only when it
  /// sends nothing.
  virtual Rgb powerToward(const Ball& target) const {
    static_cast<void>(target);
    return power();
  }
  /// Largest plausible irradiance in the box, visibility ignored: the weight with which a light is
  /// chosen. Zero only when no light can arrive there.
  virtual float importance(const Bounds3& region) const = 0;
  /// Bounds of place, direction and intensity; none for distant and infinite ones.
  virtual std::optional<LightBounds> bounds() const { return std::nullopt; }
  /// Position [render space] around which the emission falls off with distance squared; none for
  /// distant and infinite ones.
  virtual std::optional<Vec3> position() const { return std::nullopt; }
  /// Radius of a ball around position() that holds the light; 0 for those of one point.
  virtual float extent() const { return 0; }
  /// A part of range outside which no unscattered light of this one falls on the ray (spot lights:
  /// the cone). Empty when none does.
  virtual Interval illuminated(const Ray&, Interval range) const { return range; }
};

/// A light on a shape: exitant radiance.
class AreaLight : public Light {
 public:
  static constexpr std::string_view kPluginKind = "AreaLightSource";
  struct FactoryContext {
    const Shape* shape = nullptr;
    bool quick = false;  ///< --quick: a quarter of the samples
    SourceLocation where;
    Log* log = nullptr;
  };
  bool isDelta() const override { return false; }
  /// Radiance leaving the point p with normal n towards the unit vector w.
  virtual Rgb L(const Vec3& p, const Vec3& n, Vec2 uv, const Vec3& w) const = 0;
  /// Density per solid angle of sampleLi for a direction whose hit on the light's shape is known.
  virtual float pdfLiAt(const Vec3& ref, const Vec3& wi, const Vec3& hitPoint,
                        const Vec3& hitNormal) const = 0;
};

/// A direction and its density per solid angle.
struct AimedDirection {
  Vec3 w{0};
  float pdf = 0;
};
/// 1 - cos of the half angle under which the ball is seen from p; 2 (all directions) from inside.
float oneMinusCosSeen(const Vec3& p, const Ball& ball);
/// Even over the directions in which the ball lies.
AimedDirection aimAt(const Ball& ball, const Vec3& from, Vec2 u);
/// A ray of parallel light, even over the disk that the target shows along d; it starts outside of
/// the scene. Irradiance times Pi radius^2 is its power.
Vec3 startOfParallelRay(const Ball& target, const Ball& scene, const Vec3& d, Vec2 u);
/// The ball around a box.
inline Ball ballAround(const Bounds3& b) {
  return b.isEmpty() ? Ball{} : Ball{b.center(), b.radius()};
}
/// The weight of a light's colour when lights are chosen: luminance of the absolute values, so that
/// it vanishes only for black.
float lightWeight(const Rgb& c);
/// Bounds of a light at one point that shines in all directions with at most this intensity.
LightBounds pointBounds(const Vec3& position, float weight);
/// 1/d^2 [scene length^-2] from a position to the points of a region: the largest value, but no
/// more than the mean over a ball of the region's size around the position, 3/R^2.
float boundedInverseSquare(const Vec3& position, const Bounds3& region);
/// Smallest 1 - cos of the angle between a unit axis at `position` and the directions to the ball
/// around the region; 0 when the position lies inside.
float smallestOneMinusCos(const Vec3& position, const Vec3& axis, const Bounds3& region);
/// The direction from p to a light at one point, L = 1/d^2. None where they coincide.
std::optional<LightSample> samplePosition(const Vec3& p, const Vec3& lightPosition);
/// 1 - z of a vector of any length, without cancellation near z = 1.
float oneMinusCosTheta(const Vec3& w);
/// A light's parameter "from" and "to" as a frame: translation to `from`, +z towards `to`. Throws
/// SceneError when they coincide.
Transform lightFrame(const Vec3& from, const Vec3& to, const SourceLocation& where);

}  // namespace brume
