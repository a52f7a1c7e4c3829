// SPDX-License-Identifier: Apache-2.0
#include "tools/regress_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.h"
#include "core/srgb.h"
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
body {{ font: 15px/1.45 sans-serif; color: #222; max-width: 88em; margin: 1.5em auto; padding: 0 1em; }}
h1 {{ margin-bottom: .2em; }}
section {{ border-top: 1px solid #ccc; padding: 0 0 1em; }}
.pictures {{ display: flex; flex-wrap: wrap; gap: 1em; }}
figure {{ margin: 0; position: relative; width: 16.6em; }}
img {{ display: block; width: 100%; image-rendering: pixelated; }}
figure .under {{ position: absolute; left: 0; top: 0; visibility: hidden; }}
figure:hover .under {{ visibility: visible; }}
figcaption, .figures {{ color: #666; font-size: 90%; }}
.failures {{ color: #a00; padding-left: 1.2em; }}
.scale {{ display: inline-block; width: 9em; height: .8em; vertical-align: -.05em; border: 1px solid #888;
  background: linear-gradient(90deg, {scale}); }}
pre {{ white-space: pre-wrap; margin: .2em 0; }}
</style></head><body>
<h1>{failed} of {scenes} scenes failed</h1>
<p class="figures">brume {version}. The images are clipped at 1.<br>
Difference, |image - reference| / (|reference| + 0.01): 0 <span class="scale"></span> 1 and more.<br>
p-values, the chance of so large a difference between two renders of the same picture: 1 <span class="scale"></span>
1e-10 and less.</p>
{rows}</body></html>
)";

/// The colours of heatmap() as a gradient of CSS.
std::string scaleOfHeatmap() {
  constexpr int kStops = 9;
  ScalarImage ramp(kStops, 1);
  for (int i = 0; i < kStops; ++i)
    ramp.values[static_cast<std::size_t>(i)] = static_cast<float>(i) / (kStops - 1);
  std::string stops;
  for (const Rgb& colour : heatmap(ramp).pixels)
    stops += fmt::format("{}rgb({} {} {})", stops.empty() ? "" : ", ", encodeSrgb8(colour.r),
                         encodeSrgb8(colour.g), encodeSrgb8(colour.b));
  return stops;
}

std::string picture(const char* caption, const RgbImage& image, const RgbImage* under = nullptr) {
  const auto element = [&](const char* attributes, const RgbImage& pixels) {
    return fmt::format("<img {}src=\"{}\">", attributes, pngUri(pixels));
  };
  return fmt::format("<figure>{}{}<figcaption>{}</figcaption></figure>",
                     element(fmt::format("alt=\"{}\" ", caption).c_str(), image),
                     under ? element("class=\"under\" alt=\"\" ", *under) : "", caption);
}

}  // namespace

std::string RegressGallery::file(const std::string& name) const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error)
    throw SceneError(fmt::format("cannot make the folder '{}': {}", folder_, error.message()));
  return (std::filesystem::path(folder_) / name).string();
}

void RegressGallery::addRow(const RegressResult& result, const std::string& pictures) {
  ++failed_;
  rows_ += fmt::format("<section><h2>{}</h2><ul class=\"failures\">", escapeHtml(result.name));
  for (const std::string& failure : result.failures) {
    // A message with its line of the scene and a mark below keeps its shape.
    const std::string text = escapeHtml(failure);
    rows_ += text.find('\n') == std::string::npos ? "<li>" + text + "</li>"
                                                  : "<li><pre>" + text + "</pre></li>";
  }
  rows_ +=
      fmt::format("</ul><p class=\"figures\">{}</p><div class=\"pictures\">{}</div></section>\n",
                  escapeHtml(result.figures), pictures);
}

void RegressGallery::add(const RegressResult& result, const LayeredImage& image,
                         const LayeredImage& reference, const RegressVerdict& verdict) {
  writeImage(file(result.name + ".exr"), image);
  std::string pictures;
  const auto show = [&](const std::string& suffix, const char* caption, const RgbImage& shown,
                        const RgbImage* under = nullptr) {
    writeImage(file(result.name + suffix), shown);
    pictures += picture(caption, shown, under);
  };
  const RgbImage a = toRgbImage(image), b = toRgbImage(reference);
  show(".png", "image; under the pointer the reference", a, &b);
  show(".reference.png", "reference", b);
  show(".difference.png", "difference", heatmap(relativeErrorMap(a, b)));
  if (!verdict.pValues.values.empty())
    show(".p.png", "p-values of pixels", heatmap(significanceMap(verdict.pValues)));
  if (!verdict.blockPValues.values.empty())
    show(".blocks.png", "p-values of blocks", heatmap(significanceMap(verdict.blockPValues)));
  addRow(result, pictures);
}

void RegressGallery::add(const RegressResult& result) { addRow(result, ""); }

void RegressGallery::finish(std::size_t scenes) const {
  if (failed_ == 0) return;
  writeTextFile(file("index.html"),
                fmt::format(kPage, fmt::arg("failed", failed_), fmt::arg("scenes", scenes),
                            fmt::arg("version", version()), fmt::arg("scale", scaleOfHeatmap()),
                            fmt::arg("rows", rows_)));
}

}  // namespace brume
