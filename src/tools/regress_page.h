// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/io/image.h"
#include "tools/regress.h"
#include "tools/regress_judge.h"

namespace brume {

/// Collects what failed in one folder: the images of each scene and index.html, which shows them.
class RegressGallery {
 public:
  explicit RegressGallery(std::string folder) : folder_(std::move(folder)) {}

  /// A scene that was rendered and differs.
  void add(const RegressResult& result, const LayeredImage& image, const LayeredImage& reference,
           const RegressVerdict& verdict);
  /// A scene that could not be rendered or compared.
  void add(const RegressResult& result);
  /// Writes index.html when something was added; of so many scenes.
  void finish(std::size_t scenes) const;

 private:
  std::string file(const std::string& name) const;
  void addRow(const RegressResult& result, const std::string& figures);

  std::string folder_, rows_;
  std::size_t failed_ = 0;
};

}  // namespace brume
