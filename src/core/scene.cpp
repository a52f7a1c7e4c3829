// SPDX-License-Identifier: Apache-2.0
#include "core/scene.h"

namespace brume {

namespace {

/// The unit vector along A n, and what its derivative is for one of n.
struct NormalMap {
  const Transform& transform;
  Vec3 image;
  Vec3 unit;

  NormalMap(const Transform& t, const Vec3& n)
      : transform(t), image(t.normal(n)), unit(tryNormalize(image).value_or(n)) {}
  Vec3 derivative(const Vec3& dn) const {
    const Vec3 d = transform.normal(dn);
    const Vec3 result = (d - unit * dot(unit, d)) * (1 / length(image));
    return isFinite(result) ? result : Vec3(0);
  }
};

SurfaceDerivatives transformed(const SurfaceDerivatives& d, const Transform& t,
                               const NormalMap& normals) {
  return {t.vector(d.dpdu), t.vector(d.dpdv), normals.derivative(d.dndu),
          normals.derivative(d.dndv)};
}

/// Takes an interaction from an instance's space to the scene's. The normals stay on their side of
/// the surface. The error of p grows by what the next ray's origin may suffer on its way back into
/// the instance: Embree inverts and applies the matrix in float.
void transformInteraction(const Transform& t, SurfaceInteraction& si) {
  const Vec3 pError = si.pError;
  si.p = t.point(si.p, pError, &si.pError);
  const Vec3 a = abs(si.p);
  const Mat4d &m = t.matrix(), &inverse = t.inverseMatrix();
  const double reach =
      double{a.x} + a.y + a.z + std::abs(m[3][0]) + std::abs(m[3][1]) + std::abs(m[3][2]);
  Vec3d inside;
  for (int i = 0; i < 3; ++i)
    inside[i] =
        gamma(8) * reach *
        std::max({std::abs(inverse[0][i]), std::abs(inverse[1][i]), std::abs(inverse[2][i])});
  for (int i = 0; i < 3; ++i)
    si.pError[i] += static_cast<float>(std::abs(m[0][i]) * inside.x + std::abs(m[1][i]) * inside.y +
                                       std::abs(m[2][i]) * inside.z);

  const NormalMap geometric(t, si.n), shading(t, si.ns);
  si.geometry = transformed(si.geometry, t, geometric);
  si.shading = transformed(si.shading, t, shading);
  si.n = geometric.unit;
  si.ns = shading.unit;
}

SurfaceInteraction interactionInInstance(const Ray& ray, const SceneHit& hit) {
  const Transform groupToScene = hit.instance->groupToParent.at(ray.time);
  SurfaceInteraction si =
      hit.primitive->shape->interaction(groupToScene.inverse().ray(ray), hit.shape);
  transformInteraction(groupToScene, si);
  return si;
}

/// From a point towards another, the segment ending just before a surface with normal n (or 0) that
/// passes through `to`, whose error box has been left behind already.
Ray segment(const Vec3& from, const Vec3& to, const Vec3& n, float time) {
  const Vec3d d = Vec3d(to) - Vec3d(from);
  const double l = length(d);
  if (!(l > 0)) return {from, Vec3(0, 0, 1), 0.f, time};
  const Vec3 direction(d * (1 / l));
  // The direction's rounding moves the far end sideways by that much of the length, which on a
  // surface seen at a grazing angle is more along the ray.
  const double cosine = std::abs(dot(Vec3d(direction), Vec3d(n)));
  const double sideways = cosine > 0 ? std::min(1 / cosine, 1e4) : 0;
  const double end = l * (1 - 4.0 * kMachineEpsilon * (1 + sideways));
  return {from, direction, static_cast<float>(end), time};
}

Vec3 endOfShadowRay(const Vec3& from, const LightSample& to) {
  return offsetRayOrigin(to.p, to.pError, to.n, from - to.p);
}

}  // namespace

Scene::Scene(Contents contents)
    : contents_(std::move(contents)), coplanarLights_(contents_.groups.back().primitives) {
  accelerator_ = buildEmbreeAccelerator(contents_.groups);
  bounds_ = accelerator_->bounds();

  std::vector<const Volume*> volumes;
  for (const auto& volume : contents_.volumes) {
    volumes.push_back(volume.get());
    bounds_.extend(volume->bounds());
  }
  if (volumes.size() == 1) volume_ = volumes.front();
  if (volumes.size() > 1) {
    aggregate_ = makeAggregateVolume(std::move(volumes));
    volume_ = aggregate_.get();
  }

  // An empty scene is a point, so that lights need no case of their own.
  if (bounds_.isEmpty()) bounds_ = {Vec3(0), Vec3(0)};
  for (const auto& light : contents_.lights) {
    light->setSceneBounds(bounds_);
    if (light->isInfinite()) infiniteLights_.push_back(light.get());
  }
}

std::optional<SurfaceInteraction> Scene::intersect(const FootprintRay& ray, Stats& stats) const {
  std::optional<SurfaceInteraction> found;
  stats.add(Stat::IntersectionRays);
  const std::optional<SceneHit> hit = accelerator_->intersect(ray);
  if (!hit) return found;
  // Made where it stays: a copy would cost as much as all of its arithmetic.
  struct InPlace {
    const Scene& scene;
    const FootprintRay& ray;
    const SceneHit& hit;
    operator SurfaceInteraction() const { return scene.interactionAt(ray, hit); }
  };
  found.emplace(InPlace{*this, ray, *hit});
  if (!hit->instance && coplanarLights_.mayBeIn(*hit->primitive))
    if (auto light = lightIn(ray, hit->shape.t, *found)) found = std::move(light);
  found->computeFootprint(ray, Vec3(contents_.sceneOrigin));
  return found;
}

SurfaceInteraction Scene::interactionAt(const FootprintRay& ray, const SceneHit& hit) const {
  const Primitive& primitive = *hit.primitive;
  const Material* material = primitive.material;
  const bool isPlain = !ray.differential && material && !material->usesTangents();
  SurfaceInteraction si = hit.instance ? interactionInInstance(ray, hit)
                          : isPlain ? primitive.shape->interactionWithoutDerivatives(ray, hit.shape)
                                    : primitive.shape->interaction(ray, hit.shape);
  si.wo = -ray.d;
  si.time = ray.time;
  si.material = primitive.material;
  si.areaLight = primitive.areaLight;
  return si;
}

/// The area light that lies in the surface which the ray meets at t, where it shines on the ray.
std::optional<SurfaceInteraction> Scene::lightIn(const FootprintRay& ray, float t,
                                                 const SurfaceInteraction& surface) const {
  // Rounding of the places of both, along a ray that may graze them.
  const float cosine = std::max(absDot(ray.d, surface.n), 1e-3f);
  const float size = maxComponent(abs(surface.p)) + t;
  const auto found = coplanarLights_.at(ray, t, 32 * kMachineEpsilon * size / cosine);
  if (!found) return std::nullopt;
  FootprintRay around(found->ray);
  around.differential = ray.differential;
  SurfaceInteraction light = interactionAt(around, found->hit);
  if (light.areaLight->L(light.p, light.n, light.uv, light.wo).isBlack()) return std::nullopt;
  return light;
}

bool Scene::isOccluded(const Ray& ray, Stats& stats) const {
  stats.add(Stat::ShadowRays);
  return accelerator_->occluded(ray);
}

bool Scene::isMoving() const {
  const auto& instances = contents_.groups.back().instances;
  return std::ranges::any_of(instances, [](const PrimitiveGroup::Instance& instance) {
    return instance.groupToParent.isAnimated();
  });
}

Ray Scene::shadowRay(const SurfaceInteraction& from, const LightSample& to) {
  const Vec3 origin = from.offsetOrigin(to.wi);
  if (!std::isfinite(to.distance)) return {origin, to.wi, kInfinity, from.time};
  return segment(origin, endOfShadowRay(origin, to), to.n, from.time);
}

Ray Scene::shadowRay(const Vec3& from, float time, const LightSample& to) {
  if (!std::isfinite(to.distance)) return {from, to.wi, kInfinity, time};
  return segment(from, endOfShadowRay(from, to), to.n, time);
}

}  // namespace brume
