// SPDX-License-Identifier: Apache-2.0
// PBRT-v2 directives that choose something which brume has only one of. Their plugins check and
// describe names and parameters, and do nothing else.
#pragma once

#include <string_view>

#include "core/params.h"

namespace brume {

struct ChoiceFactoryContext {
  SourceLocation where;
  Log* log = nullptr;
};

/// Accelerator: brume intersects with Embree, whatever the scene names.
class AcceleratorChoice {
 public:
  static constexpr std::string_view kPluginKind = "Accelerator";
  using FactoryContext = ChoiceFactoryContext;
  virtual ~AcceleratorChoice() = default;
};

/// Renderer: brume's image loop follows from the integrators.
class RendererChoice {
 public:
  static constexpr std::string_view kPluginKind = "Renderer";
  using FactoryContext = ChoiceFactoryContext;
  virtual ~RendererChoice() = default;
};

}  // namespace brume
