// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <mutex>

#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_measured.h"

namespace brume {
namespace {

/// The table of a file, shared by all materials that name it while one of them lives: exporters
/// write the same material before every shape, and a MERL table is 17 MB.
template <class Brdf>
std::shared_ptr<const Brdf> loadOnce(const std::string& path, const SourceLocation& where) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const Brdf>> loaded;
  const std::lock_guard lock(mutex);
  std::weak_ptr<const Brdf>& entry = loaded[path];
  if (auto present = entry.lock()) return present;
  auto brdf = std::make_shared<const Brdf>(path, where);
  entry = brdf;
  return brdf;
}

/// A measured isotropic BRDF from a file: the MERL format (see MerlBrdf), or, by the suffix .brdf,
/// a text of irregular samples (see IrregularBrdf). Reflects on both sides. Test: measured_test.
class Measured final : public Material {
 public:
  struct Params {
    Filename filename;
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(filename, "filename",
        "the measurement: .brdf (text, irregular samples) or the MERL format (binary)");
      declareBumpMap(v, bumpmap);
    }
  };

  Measured(Params params, const FactoryContext& context) : params_(std::move(params)) {
    const Filename& file = params_.filename;
    if (!file.isGiven())
      throw SceneError(context.where, "Material 'measured' needs the parameter 'string filename'");
    const SourceLocation& where = file.where.isKnown() ? file.where : context.where;
    if (file.path.ends_with(".brdf") || file.path.ends_with(".BRDF"))
      irregular_ = loadOnce<IrregularBrdf>(file.path, where);
    else
      merl_ = loadOnce<MerlBrdf>(file.path, where);
  }

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction&, Bsdf& bsdf) const override {
    if (merl_)
      bsdf.add<MerlLobe>(*merl_);
    else
      bsdf.add<IrregularLobe>(*irregular_);
  }

 private:
  Params params_;
  std::shared_ptr<const MerlBrdf> merl_;  // one of the two
  std::shared_ptr<const IrregularBrdf> irregular_;
};

const RegisterPlugin<Material, Measured> kRegistration{
    "measured", Origin::PbrtV2, "measured isotropic BRDF, MERL or irregular samples"};

}  // namespace
}  // namespace brume
