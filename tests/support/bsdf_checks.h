// SPDX-License-Identifier: Apache-2.0
// What the tests of materials share: a surface point, directions, quadrature and chi-square.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/material.h"
#include "support/make_plugin.h"

namespace brume::test {

/// A point of a plane in no special position, seen without footprint.
SurfaceInteraction planePoint();

/// The render-space direction with the local coordinates w in the frame of planePoint().
Vec3 fromPlane(const Vec3& w);

/// Local unit vector of the given cosine and azimuth.
Vec3 localDirection(float cosine, float phi);

/// Named materials for mix.
class NamedMaterials final : public Material::FactoryContext::Lookup {
 public:
  void add(const std::string& name, std::unique_ptr<Material> material) {
    names_.push_back(name);
    materials_.push_back(std::move(material));
  }
  const Material* findMaterial(const std::string& name) override {
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (names_[i] == name) return materials_[i].get();
    return nullptr;
  }
  std::vector<std::string> materialNames() const override { return names_; }

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<Material>> materials_;
};

/// Int f |cos| dwi over the whole sphere, non-specular lobes, by the midpoint rule with n x 2n
/// cells over (cos, phi).
Rgb integrateF(const Bsdf& bsdf, const Vec3& wo, int n);

/// Draws samples of the non-specular lobes and compares their histogram over the sphere, rejected
/// ones included, with the integrals of pdf. Returns the p-value: small means that they differ.
double chiSquareOfSampling(const Bsdf& bsdf, const Vec3& wo, int samples);

/// Mean and standard error per channel of the estimator f |cos| / pdf over all lobes.
struct Estimate {
  double mean[3] = {0, 0, 0}, error[3] = {0, 0, 0};
};
Estimate estimateAlbedo(const Bsdf& bsdf, const Vec3& wo, LobeFlags accepted, int samples);

}  // namespace brume::test
