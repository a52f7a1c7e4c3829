// SPDX-License-Identifier: Apache-2.0
#include "tools/regress_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.h"
#include "core/version.h"
#include "tools/image_metrics.h"
#include "tools/text_file.h"
#include "tools/web_page.h"

namespace brume {
namespace {

constexpr const char* kPage = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>brume regress: {failed} failed</title>
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<style>
body {{ font: 15px/1.4 sans-serif; margin: 2em; max-width: 84em; }}
section {{ border-top: 1px solid #ccc; padding: 1em 0; }}
figure {{ display: inline-block; margin: 0 1em 0 0; }}
img {{ width: 16em; image-rendering: pixelated; background: #888; }}
figcaption, .figures {{ color: #555; font-size: 90%; }}
li {{ color: #a00; }}
</style></head><body>
<h1>{failed} failed</h1>
<p>brume {version}. Difference: |image - reference| / (|reference| + 0.01) from black (0) to pale yellow (1 and
more). p-values: black where the difference is noise (p = 1) to pale yellow (p = 1e-10 and less).</p>
{rows}</body></html>
)";

}  // namespace

std::string RegressGallery::file(const std::string& name) const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error)
    throw SceneError(fmt::format("cannot make the folder '{}': {}", folder_, error.message()));
  return (std::filesystem::path(folder_) / name).string();
}

void RegressGallery::addRow(const RegressResult& result, const std::string& figures) {
  rows_ += fmt::format("<section><h2>{}</h2><ul>", escapeHtml(result.name));
  for (const std::string& failure : result.failures)
    rows_ += fmt::format("<li>{}</li>", escapeHtml(failure));
  rows_ += fmt::format("</ul><p class=\"figures\">{}</p>{}</section>\n", escapeHtml(result.figures),
                       figures);
}

void RegressGallery::add(const RegressResult& result, const LayeredImage& image,
                         const LayeredImage& reference, const RegressVerdict& verdict) {
  writeImage(file(result.name + ".exr"), image);
  std::string figures;
  const auto show = [&](const std::string& suffix, const char* caption, const RgbImage& picture) {
    writeImage(file(result.name + suffix), picture);
    figures +=
        fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>",
                    caption, pngUri(picture));
  };
  const RgbImage a = toRgbImage(image), b = toRgbImage(reference);
  show(".png", "image", a);
  show(".reference.png", "reference", b);
  show(".difference.png", "difference", heatmap(relativeErrorMap(a, b)));
  if (!verdict.pValues.values.empty())
    show(".p.png", "p-values", heatmap(significanceMap(verdict.pValues)));
  addRow(result, figures);
}

void RegressGallery::add(const RegressResult& result) { addRow(result, ""); }

void RegressGallery::finish() const {
  if (rows_.empty()) return;
  std::size_t failed = 0;
  for (std::size_t at = rows_.find("<section>"); at != std::string::npos;
       at = rows_.find("<section>", at + 1))
    ++failed;
  writeTextFile(file("index.html"),
                fmt::format(kPage, fmt::arg("failed", failed), fmt::arg("version", version()),
                            fmt::arg("rows", rows_)));
}

}  // namespace brume
