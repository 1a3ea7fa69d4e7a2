#include "tools/image_files.h"

#include "core/error.h"
#include "core/file_format.h"
#include "core/image_library.h"
#include "core/output_file.h"
#include "kernels/denoise/denoise.h"
#include "tools/commands.h"
#include "tools/interrupted_image.h"

#include <algorithm>
#include <cctype>

namespace sheaf {

namespace fs = std::filesystem;

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void check_image_name(const fs::path& path) {
  const std::string extension = extension_of(path);
  if (extension != ".exr" && extension != ".png")
    throw Error(ExitCode::kUsage, "the name of the output image '" + path.string() + "' must end in .exr or .png");
}

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
  const FileFormat format = file_format(file);
  const std::string expected = ", expected an OpenEXR image, as written by 'sheaf render -o NAME.exr'";
  if (format.use == FileUse::kUnknown) throw SceneError({file.string(), 0}, "has an unknown format" + expected);
  if (extension_of(file) == ".exr" && !format.by_content)
    throw SceneError({file.string(), 0}, "does not start like an OpenEXR file: it is damaged or has another format");
  const bool loses = format.use == FileUse::kImage;
  throw SceneError({file.string(), 0},
                   "is " + format.name + expected + (loses ? "; other formats lack the required layers" : ""));
}

void check_is_image(const fs::path& file) {
  if (!fs::is_regular_file(file)) return;
  const FileFormat format = file_format(file);
  if (format.use == FileUse::kImage) {
    if (extension_of(file) == ".exr") check_is_exr(file);
    return;
  }
  if (format.use == FileUse::kUnknown) return;
  throw SceneError(
      {file.string(), 0},
      "is " + format.name + ", expected an image: OpenEXR, PNG, JPEG, Radiance HDR, TIFF, WebP, TGA or BMP");
}

void check_overwriting(std::span<const NamedFile> written, std::span<const NamedFile> sources) {
  const auto shown = [](const NamedFile& file) { return file.what + " '" + file.file.string() + "'"; };
  for (std::size_t i = 0; i < written.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      if (is_same_file(written[i].file, written[k].file))
        throw Error(ExitCode::kUsage, shown(written[i]) + " would overwrite " + shown(written[k]));
    std::error_code error;
    if (!fs::exists(written[i].file, error)) continue;
    for (const NamedFile& source : sources)
      if (is_same_file(written[i].file, source.file))
        throw Error(ExitCode::kUsage, shown(written[i]) + " would overwrite " + shown(source));
  }
}

void check_all_writable(std::span<const NamedFile> written) {
  for (const NamedFile& output : written) {
    check_writable(output.file);
    if (extension_of(output.file) == ".png") image_library();
  }
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

std::vector<fs::path> write_images(const std::vector<fs::path>& files, const Image& image,
                                   const ExrMetadata& metadata) {
  std::vector<fs::path> written;
  const bool denoised = image.find_channel("denoised.R") >= 0;
  for (const fs::path& file : files) {
    const bool is_png = extension_of(file) == ".png";
    if (try_to_write([&] {
          is_png ? write_png(file, denoised ? denoised_only(image) : image, interruption(metadata.attributes))
                 : write_exr(file, image, metadata);
        }))
      written.push_back(file);
  }
  return written;
}

}  // namespace sheaf
