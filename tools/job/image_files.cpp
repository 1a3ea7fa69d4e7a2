#include "tools/job/image_files.h"

#include "core/image/image_formats.h"
#include "core/io/error.h"
#include "core/io/name_table.h"
#include "core/io/output_file.h"
#include "kernels/denoise/denoise.h"
#include "scene/formats/model_formats.h"
#include "tools/console/messages.h"
#include "tools/job/interrupted_image.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace sheaf {

namespace fs = std::filesystem;

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

namespace {

/// The format of an output image, by its name; nullopt for OpenEXR. Throws Error (exit code 2).
std::optional<IntegerFormat> output_format(const fs::path& path) {
  const std::string extension = extension_of(path);
  std::vector<std::string> known{".exr"};
  if (extension == known.front()) return std::nullopt;
  for (const ImageFormat& format : image_formats()) {
    if (!format.written) continue;
    for (const std::string_view written : format.extensions) {
      if (extension == written) return format.written;
      known.emplace_back(written);
    }
  }
  throw Error(ExitCode::kUsage,
              fmt::format("the name of the output image '{}' must end in {}", path.string(), one_of(known)));
}

}  // namespace

void check_image_name(const fs::path& path) { output_format(path); }

std::vector<NamedFile> named_images(const std::vector<std::string>& files) {
  std::vector<NamedFile> images;
  for (const std::string& file : files) {
    check_image_name(file);
    images.push_back({"the image", file});
  }
  return images;
}

void check_is_exr(const fs::path& file) {
  if (!fs::is_regular_file(file) || is_exr(file)) return;
  const FileFormat format = file_or_model_format(file);
  const std::string expected = ", expected an OpenEXR image, as written by 'sheaf render -o NAME.exr'";
  if (format.use == FileUse::kUnknown)
    throw SceneError(SourceLocation{file.string(), 0}, "has an unknown format" + expected);
  if (extension_of(file) == ".exr" && !format.by_content)
    throw SceneError(SourceLocation{file.string(), 0},
                     "does not start like an OpenEXR file: it is damaged or has another format");
  const bool loses = format.use == FileUse::kImage;
  throw SceneError(
      SourceLocation{file.string(), 0},
      fmt::format("is {}{}{}", format.name, expected, loses ? "; other formats lack the required layers" : ""));
}

void check_is_image(const fs::path& file) {
  if (!fs::is_regular_file(file)) return;
  const FileFormat format = file_or_model_format(file);
  if (format.use == FileUse::kImage) {
    if (extension_of(file) == ".exr") check_is_exr(file);
    return;
  }
  if (format.use == FileUse::kUnknown) return;
  throw SceneError(SourceLocation{file.string(), 0},
                   fmt::format("is {}, expected an image: {}", format.name, list_image_formats()));
}

void check_overwriting(std::span<const NamedFile> written, std::span<const NamedFile> sources) {
  const auto quoted = [](const NamedFile& file) { return fmt::format("{} '{}'", file.what, file.file.string()); };
  for (std::size_t i = 0; i < written.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      if (is_same_file(written[i].file, written[k].file))
        throw Error(ExitCode::kUsage, fmt::format("{} would overwrite {}", quoted(written[i]), quoted(written[k])));
    std::error_code error;
    if (!fs::exists(written[i].file, error)) continue;
    for (const NamedFile& source : sources)
      if (is_same_file(written[i].file, source.file))
        throw Error(ExitCode::kUsage, fmt::format("{} would overwrite {}", quoted(written[i]), quoted(source)));
  }
}

void check_all_writable(std::span<const NamedFile> written) {
  for (const NamedFile& output : written) check_writable(output.file);
}

bool try_to_write(const std::function<void()>& write) {
  try {
    write();
    return true;
  } catch (const std::exception& error) {
    print_message(error.what());
    return false;
  }
}

Image displayed_image(const Image& image, const OutputSettings& settings, std::optional<double>& exposure) {
  const bool denoised = image.find_channel("denoised.R") >= 0;
  Image displayed = denoised ? denoised_only(image) : image;
  if (settings.display.is_automatic()) exposure = settings.display.exposure_of(displayed);
  return settings.display.is_identity() ? displayed : settings.display.apply(displayed);
}

void write_image(const fs::path& file, const Image& image, const ExrMetadata& metadata, const OutputSettings& settings,
                 const std::function<const Image&()>& display) {
  const std::optional<IntegerFormat> format = output_format(file);
  if (!format) {
    ExrMetadata stored = metadata;
    stored.compression = settings.compression;
    stored.dwa_level = settings.dwa_level;
    return write_exr(file, image, stored);
  }
  IntegerEncoding encoding;
  encoding.format = *format;
  encoding.quality = settings.jpeg_quality;
  encoding.description = interruption(metadata.attributes);
  write_encoded_image(file, display(), encoding);
}

namespace {

/// Sets what the displayed image shows, and the exposure that would show a picture if it does not.
void add_exposure_hint(const Image& image, const Image& displayed, const OutputSettings& settings,
                       WrittenImages& written) {
  constexpr double kMinDifference = 1;  // stops
  const Shown shown = shown_by(displayed);
  if (shown == Shown::kPicture) return;
  const Image source = image.find_channel("denoised.R") >= 0 ? denoised_only(image) : image;
  written.helpful_exposure = auto_exposure(source);
  if (std::abs(written.helpful_exposure - settings.display.exposure_of(source)) > kMinDifference) written.shown = shown;
}

}  // namespace

WrittenImages write_images(const std::vector<fs::path>& files, const Image& image, const ExrMetadata& metadata,
                           const OutputSettings& settings) {
  WrittenImages written;
  // Make the displayed image once, for the first file that shows it
  const bool is_changed = image.find_channel("denoised.R") >= 0 || !settings.display.is_identity();
  std::optional<Image> displayed;
  const auto display = [&]() -> const Image& {
    if (!is_changed) return image;
    if (!displayed) displayed = displayed_image(image, settings, written.exposure);
    return *displayed;
  };
  for (const fs::path& file : files)
    if (try_to_write([&] { write_image(file, image, metadata, settings, display); })) written.files.push_back(file);
  const auto is_display = [](const fs::path& file) { return output_format(file).has_value(); };
  if (!settings.display.is_automatic() && std::any_of(written.files.begin(), written.files.end(), is_display))
    add_exposure_hint(image, display(), settings, written);
  return written;
}

}  // namespace sheaf
