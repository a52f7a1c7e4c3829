// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/integrator.h"

namespace brume {

/// Emission and transmittance of the scene's media, both exact: what global integrators give to
/// code that asks a volume integrator.
class MediaTransmittance final : public VolumeIntegrator {
 public:
  explicit MediaTransmittance(const Volume* volume) : volume_(volume) {}
  VolumeRadiance integrate(const Ray& ray, RenderContext&) const override {
    const auto range = volume_ ? volume_->intersect(ray) : std::nullopt;
    if (!range) return {};
    return {volume_->emission(ray, *range), volume_->transmittance(ray, *range)};
  }
  Rgb transmittance(const Ray& ray, RenderContext&) const override {
    return volume_ ? volume_->transmittance(ray) : Rgb(1.f);
  }

 private:
  const Volume* volume_;
};

}  // namespace brume
