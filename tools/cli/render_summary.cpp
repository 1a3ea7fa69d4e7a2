#include "tools/cli/render_summary.h"

#include "tools/console/duration.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

/// A fraction in percent with two significant digits.
std::string percent(double fraction) {
  return fraction >= 0.995 ? fmt::format("{:.0f} %", fraction * 100) : fmt::format("{:.2g} %", fraction * 100);
}

}  // namespace

std::string written_files(const WrittenImages& written) {
  std::string text;
  for (const std::filesystem::path& file : written.files) text += (text.empty() ? "wrote " : ", ") + file.string();
  if (written.exposure) return fmt::format("{} (exposure {})", text, exposure_text(*written.exposure));
  if (written.shown == Shown::kPicture) return text;
  return fmt::format("{} (almost {}: --exposure {:.2g} shows a picture)", text,
                     written.shown == Shown::kBlack ? "black" : "white", written.helpful_exposure);
}

std::string summarize(const RenderReport& report, const WrittenImages& written) {
  std::string text =
      fmt::format("{} {}x{}, ", report.interrupted ? "interrupted:" : "rendered", report.width, report.height);
  if (report.interrupted && !report.adaptive)
    text += fmt::format("{:.4g} of {} spp", report.mean_samples, report.spp);
  else if (report.adaptive)
    text += fmt::format("{:.4g} spp on average", report.adaptive->mean_samples);
  else
    text += fmt::format("{} spp", report.spp);
  text += " in " + format_duration(report.render_seconds);
  if (report.noise && *report.noise > 0) text += ", noise " + percent(*report.noise);
  if (report.adaptive && report.adaptive->noise_target > 0 && report.adaptive->reached < report.adaptive->tiles)
    text += fmt::format(" ({} of {} tiles have enough samples for {})", report.adaptive->reached,
                        report.adaptive->tiles, percent(report.adaptive->noise_target));
  if (!written.denoiser.empty()) text += ", denoised by " + written.denoiser;
  if (const std::string files = written_files(written); !files.empty()) text += "; " + files;
  return text;
}

}  // namespace sheaf
