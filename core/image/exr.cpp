// EXR reading and writing. The only file that includes OpenEXR and Imath.
#include "core/image/exr.h"

#include "core/color/color.h"
#include "core/image/exr_check.h"
#include "core/image/exr_halves.h"
#include "core/io/error.h"
#include "core/io/output_file.h"

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfTestFile.h>
#include <ImfThreading.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

Imath::V2f to_imath(Vec2f v) { return {v.x, v.y}; }

Imf::Compression imf_compression(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kUncompressed:
      return Imf::NO_COMPRESSION;
    case ExrCompression::kRle:
      return Imf::RLE_COMPRESSION;
    case ExrCompression::kZips:
      return Imf::ZIPS_COMPRESSION;
    case ExrCompression::kPiz:
      return Imf::PIZ_COMPRESSION;
    case ExrCompression::kDwaa:
      return Imf::DWAA_COMPRESSION;
    case ExrCompression::kDwab:
      return Imf::DWAB_COMPRESSION;
    case ExrCompression::kZip:
      break;
  }
  return Imf::ZIP_COMPRESSION;
}

bool is_dwa(ExrCompression compression) {
  return compression == ExrCompression::kDwaa || compression == ExrCompression::kDwab;
}

Imf::Header make_header(const Image& image, const ExrMetadata& metadata) {
  const Imath::Box2i frame({0, 0}, {image.frame_width - 1, image.frame_height - 1});
  const Imath::Box2i window({image.x0, image.y0}, {image.x0 + image.width - 1, image.y0 + image.height - 1});
  Imf::Header header(frame, window);
  // Set the compression and standard attributes
  header.compression() = imf_compression(metadata.compression);
  if (is_dwa(metadata.compression)) header.dwaCompressionLevel() = metadata.dwa_level;
  header.lineOrder() = Imf::INCREASING_Y;
  const auto& xy = kRec709Chromaticities;
  const Imf::Chromaticities chromaticities(to_imath(xy[0]), to_imath(xy[1]), to_imath(xy[2]), to_imath(xy[3]));
  header.insert("chromaticities", Imf::ChromaticitiesAttribute(chromaticities));
  if (!metadata.software.empty()) header.insert("Software", Imf::StringAttribute(metadata.software));
  if (metadata.capture_date) header.insert("capDate", Imf::StringAttribute(*metadata.capture_date));
  // Add the camera transform
  if (metadata.world_to_camera) {
    Imath::M44f matrix;  // Imath multiplies row vectors
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
        matrix[column][row] = static_cast<float>(metadata.world_to_camera->m[r][c]);
      }
    }
    header.insert("worldToCamera", Imf::M44fAttribute(matrix));
  }
  // Add the custom attributes
  for (const ExrMetadata::Attribute& attribute : metadata.attributes) {
    const char* name = attribute.name.c_str();
    if (const auto* i = std::get_if<int>(&attribute.value)) header.insert(name, Imf::IntAttribute(*i));
    if (const auto* f = std::get_if<float>(&attribute.value)) header.insert(name, Imf::FloatAttribute(*f));
    if (const auto* d = std::get_if<double>(&attribute.value)) header.insert(name, Imf::DoubleAttribute(*d));
    if (const auto* s = std::get_if<std::string>(&attribute.value)) header.insert(name, Imf::StringAttribute(*s));
  }
  return header;
}

/// A frame buffer slice over interleaved values. `first` is the value of the upper left pixel of the window.
Imf::Slice make_slice(Imf::PixelType type, void* first, std::size_t value_bytes, const Image& image,
                      std::size_t values_per_pixel) {
  const std::size_t pixel = value_bytes * values_per_pixel, row = pixel * static_cast<std::size_t>(image.width);
  return Imf::Slice::Make(type, first, Imath::V2i(image.x0, image.y0), image.width, image.height, pixel, row);
}

void check_image(const Image& image) {
  const bool sizes_match = image.data.size() == image.pixel_count() * image.channels.size();
  if (image.pixel_count() == 0 || image.channels.empty() || image.frame_width <= 0 || image.frame_height <= 0 ||
      !sizes_match) {
    throw Error(ExitCode::kOutput, "an image without pixels or with missing values cannot be written");
  }
}

/// Output stream of OpenEXR. The library swallows errors at the end of a file, when it goes back to write the line
/// offset table. OutputFile::commit() reports those.
class ExrStream : public Imf::OStream {
 public:
  ExrStream(std::ostream& stream, const std::string& name) : Imf::OStream(name.c_str()), stream_(stream) {}

  void write(const char bytes[], int count) override {
    errno = 0;
    stream_.write(bytes, count);
    if (!stream_)
      throw std::runtime_error(errno != 0 ? std::strerror(errno) : "the data could not be written completely");
  }
  std::uint64_t tellp() override { return static_cast<std::uint64_t>(stream_.tellp()); }
  void seekp(std::uint64_t position) override { stream_.seekp(static_cast<std::streamoff>(position)); }

 private:
  std::ostream& stream_;
};

void write_pixels(ExrStream& stream, const Image& image, const ExrMetadata& metadata) {
  // Declare the channels and their slices
  Imf::Header header = make_header(image, metadata);
  Imf::FrameBuffer buffer;
  std::vector<std::vector<half>> halves;
  halves.reserve(image.channels.size());
  float* const values = const_cast<float*>(image.data.data());  // Imf::Slice has no const version
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    const std::string& name = image.channels[c];
    const auto& requested = metadata.half_channels;
    if (std::find(requested.begin(), requested.end(), name) == requested.end()) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      buffer.insert(name, make_slice(Imf::FLOAT, values + c, sizeof(float), image, image.channels.size()));
      continue;
    }
    std::vector<half>& column = halves.emplace_back(image.pixel_count());
    for (std::size_t i = 0; i < column.size(); ++i) column[i] = half(values[i * image.channels.size() + c]);
    header.channels().insert(name, Imf::Channel(Imf::HALF));
    buffer.insert(name, make_slice(Imf::HALF, column.data(), sizeof(half), image, 1));
  }
  // Write the pixels
  Imf::OutputFile file(stream, header, 0);
  file.setFrameBuffer(buffer);
  file.writePixels(image.height);
}

/// Calls `read` with the open file and converts the exceptions of the library to Error.
template <class Read> void with_exr_file(const fs::path& path, Read read) {
  const SourceLocation where{path.string(), 0};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw SceneError(where, "image file not found");
  if (!is_exr(path)) throw SceneError(where, "this is not an OpenEXR file");
  check_exr_headers(path);
  Imf::setGlobalThreadCount(0);
  try {
    Imf::MultiPartInputFile file(path.string().c_str(), 0);
    read(file);
  } catch (const Error&) { throw; } catch (const std::bad_alloc&) {
    throw Error(ExitCode::kRuntime, where, "not enough memory for this image");
  } catch (const std::exception& problem) {
    throw SceneError(where, std::string("cannot read the image: ") + problem.what());
  }
}

bool is_deep(const Imf::Header& header) { return header.hasType() && Imf::isDeepData(header.type()); }

std::vector<std::string> channel_names(const Imf::Header& header) {
  std::vector<std::string> names;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    names.emplace_back(channel.name());
  return names;
}

/// An image with the size and position of a part and the channels `names`, without its values of `value_bytes` each.
/// Throws SceneError.
Image prepare_image(const fs::path& path, const Imf::Header& header, std::vector<std::string> names,
                    std::size_t value_bytes) {
  // Check the channels
  const SourceLocation where{path.string(), 0};
  if (is_deep(header)) throw SceneError(where, "deep images are not supported");
  for (const std::string& name : names) {
    const Imf::Channel* channel = header.channels().findChannel(name.c_str());
    if (channel == nullptr) throw SceneError(where, fmt::format("the image has no channel '{}'", name));
    if (channel->xSampling != 1 || channel->ySampling != 1) {
      throw SceneError(where, fmt::format("channel '{}' is subsampled, which is not supported", name));
    }
  }
  // Check the windows
  const Imath::Box2i &window = header.dataWindow(), &frame = header.displayWindow();
  const auto extent = [](int low, int high) { return static_cast<long long>(high) - low + 1; };
  const auto too_far = [](int v) { return std::abs(static_cast<long long>(v)) > (1 << 24); };
  const long long width = extent(window.min.x, window.max.x), height = extent(window.min.y, window.max.y);
  check_image_size(path, width, height, names.size(), fs::file_size(path));
  for (const int corner : {window.min.x, window.min.y, frame.min.x, frame.min.y, frame.max.x, frame.max.y}) {
    if (too_far(corner)) throw SceneError(where, "a window of the image is too far from the origin");
  }
  // Create the image
  check_image_memory(path, width, height, names.size(), value_bytes);
  Image image;
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.channels = std::move(names);
  image.x0 = window.min.x - frame.min.x;
  image.y0 = window.min.y - frame.min.y;
  image.frame_width = static_cast<int>(extent(frame.min.x, frame.max.x));
  image.frame_height = static_cast<int>(extent(frame.min.y, frame.max.y));
  return image;
}

/// Reads the values of the channels of an image that prepare_image() returned.
template <class Value>
std::vector<Value> read_values(Imf::MultiPartInputFile& file, int index, const Image& image, Imf::PixelType type) {
  const Imf::Header& header = file.header(index);
  std::vector<Value> values(image.pixel_count() * image.channels.size());
  Imf::InputPart part(file, index);
  Image placed;  // no values: slices use the coordinates of the file, not of the frame
  placed.width = image.width;
  placed.x0 = header.dataWindow().min.x;
  placed.y0 = header.dataWindow().min.y;
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    buffer.insert(image.channels[c], make_slice(type, values.data() + c, sizeof(Value), placed, image.channels.size()));
  }
  part.setFrameBuffer(buffer);
  part.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  return values;
}

Image read_part(const fs::path& path, Imf::MultiPartInputFile& file, int index, std::vector<std::string> names) {
  Image image = prepare_image(path, file.header(index), std::move(names), sizeof(float));
  image.data = read_values<float>(file, index, image, Imf::FLOAT);
  return image;
}

}  // namespace

ExrMetadata::Attribute integer_attribute(std::string name, std::uint64_t value) {
  if (value <= static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
    return {std::move(name), static_cast<int>(value)};
  return {std::move(name), static_cast<double>(value)};
}

std::optional<double> number_of(const ExrMetadata::Attribute& attribute) {
  if (const auto* i = std::get_if<int>(&attribute.value)) return *i;
  if (const auto* f = std::get_if<float>(&attribute.value)) return static_cast<double>(*f);
  if (const auto* d = std::get_if<double>(&attribute.value)) return *d;
  const auto& text = std::get<std::string>(attribute.value);
  double number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

bool is_exr(const fs::path& path) { return Imf::isOpenExrFile(path.string().c_str()); }

void write_exr(const fs::path& path, const Image& image, const ExrMetadata& metadata) {
  check_image(image);
  Imf::setGlobalThreadCount(0);
  OutputFile file(path);
  try {
    ExrStream stream(file.stream(), path.string());
    write_pixels(stream, image, metadata);
  } catch (const std::exception& problem) {
    if (!file.stream()) file.commit();  // reports the actual reason
    throw Error(ExitCode::kOutput, fmt::format("cannot write '{}': {}", path.string(), problem.what()));
  }
  file.commit();
}

Image read_exr(const fs::path& path) {
  Image image;
  with_exr_file(
      path, [&](Imf::MultiPartInputFile& file) { image = read_part(path, file, 0, channel_names(file.header(0))); });
  return image;
}

std::vector<ExrPart> read_exr_parts(const fs::path& path) {
  std::vector<ExrPart> parts;
  with_exr_file(path, [&](Imf::MultiPartInputFile& file) {
    for (int i = 0; i < file.parts(); ++i) {
      const Imf::Header& header = file.header(i);
      ExrPart& part = parts.emplace_back();
      if (header.hasName()) part.name = header.name();
      part.deep = is_deep(header);
      part.channels = channel_names(header);
      const auto* attribute = header.findTypedAttribute<Imf::ChromaticitiesAttribute>("chromaticities");
      if (attribute == nullptr) continue;
      const auto xy = [](const Imath::V2f& v) {
        return Chromaticity{static_cast<double>(v.x), static_cast<double>(v.y)};
      };
      const Imf::Chromaticities& c = attribute->value();
      part.chromaticities = {xy(c.red), xy(c.green), xy(c.blue), xy(c.white)};
    }
  });
  return parts;
}

Image read_exr_channels(const fs::path& path, std::size_t part, std::vector<std::string> channels) {
  Image image;
  with_exr_file(path, [&](Imf::MultiPartInputFile& file) {
    image = read_part(path, file, static_cast<int>(part), std::move(channels));
  });
  return image;
}

std::optional<HalfImage> read_exr_half_channels(const fs::path& path, std::size_t part,
                                                std::vector<std::string> channels) {
  std::optional<HalfImage> halves;
  with_exr_file(path, [&](Imf::MultiPartInputFile& file) {
    const auto index = static_cast<int>(part);
    const Imf::Header& header = file.header(index);
    if (header.dataWindow() != header.displayWindow()) return;
    for (const std::string& name : channels) {
      const Imf::Channel* channel = header.channels().findChannel(name.c_str());
      if (channel != nullptr && channel->type != Imf::HALF) return;
    }
    const Image image = prepare_image(path, header, std::move(channels), sizeof(std::uint16_t));
    halves = {image.width, image.height, image.channels, read_values<std::uint16_t>(file, index, image, Imf::HALF)};
  });
  return halves;
}

std::vector<ExrMetadata::Attribute> read_exr_attributes(const fs::path& path) {
  return read_exr_header(path).attributes;
}

ExrHeader read_exr_header(const fs::path& path) {
  ExrHeader out;
  with_exr_file(path, [&](Imf::MultiPartInputFile& file) {
    const Imf::Header& header = file.header(0);
    const auto rect = [](const Imath::Box2i& box) {
      return PixelRect{box.min.x, box.min.y, box.max.x + 1, box.max.y + 1};
    };
    // Read the windows and channels
    out.frame = rect(header.displayWindow());
    out.window = rect(header.dataWindow());
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
      const Imf::PixelType type = channel.channel().type;
      out.channels.push_back({channel.name(), type == Imf::HALF ? "half" : type == Imf::UINT ? "uint" : "float"});
    }
    // Read attributes of supported types
    for (auto item = header.begin(); item != header.end(); ++item) {
      const Imf::Attribute& attribute = item.attribute();
      if (const auto* i = dynamic_cast<const Imf::IntAttribute*>(&attribute)) {
        out.attributes.push_back({item.name(), i->value()});
      } else if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
        out.attributes.push_back({item.name(), f->value()});
      } else if (const auto* d = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) {
        out.attributes.push_back({item.name(), d->value()});
      } else if (const auto* s = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
        out.attributes.push_back({item.name(), s->value()});
      }
    }
  });
  return out;
}

ExrMetadata read_exr_metadata(const fs::path& path) {
  ExrMetadata metadata;
  metadata.attributes = read_exr_attributes(path);
  // Move standard attributes to their members
  std::erase_if(metadata.attributes, [&](const ExrMetadata::Attribute& attribute) {
    const auto* text = std::get_if<std::string>(&attribute.value);
    if (text != nullptr && attribute.name == "Software") metadata.software = *text;
    if (text != nullptr && attribute.name == "capDate") metadata.capture_date = *text;
    const auto& name = attribute.name;  // copied above, or written by the library itself
    return name == "Software" || name == "capDate" || name == "type" || name == "name" || name == "chunkCount" ||
           name == "pixelAspectRatio" || name == "screenWindowWidth";
  });
  with_exr_file(path, [&](Imf::MultiPartInputFile& file) {
    const Imf::Header& header = file.header(0);
    // Read the camera transform and the pixel types
    if (const auto* matrix = header.findTypedAttribute<Imf::M44fAttribute>("worldToCamera")) {
      Matrix4& to = metadata.world_to_camera.emplace();
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
          to.m[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = matrix->value()[column][row];
    }
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
      if (channel.channel().type == Imf::HALF) metadata.half_channels.emplace_back(channel.name());
  });
  return metadata;
}

}  // namespace sheaf
