// The containers of glTF: .gltf and .glb files, external files and data URIs.
#include "scene/formats/gltf_document.h"

#include "scene/formats/little_endian.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/model_import.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace sheaf {

using nlohmann::json;

GltfDocument::GltfDocument() : json(std::make_unique<nlohmann::json>()) {}
GltfDocument::GltfDocument(GltfDocument&&) noexcept = default;
GltfDocument::~GltfDocument() = default;

namespace {

/// Nesting of valid documents is shallow; the library recurses.
constexpr int kMaxDepth = 64;

json parse_json(std::string_view text, const std::filesystem::path& file) {
  const auto check_depth = [&](int depth, json::parse_event_t, json&) {
    if (depth > kMaxDepth) throw SceneError(SourceLocation{file.string(), 0}, "the JSON is nested too deeply");
    return true;
  };
  try {
    json document = json::parse(text.begin(), text.end(), check_depth);
    if (!document.is_object())
      throw SceneError(SourceLocation{file.string(), 1}, "is not a glTF document: the JSON is no object");
    return document;
  } catch (const json::out_of_range&) {
    throw SceneError(SourceLocation{file.string(), 0}, "has a number that is too large");
  } catch (const json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto line = static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
    throw SceneError(SourceLocation{file.string(), line + 1}, "is not valid JSON");
  }
}

/// Reads the chunks of a .glb file, which ends where its header says (glTF 2.0, 4.4.2).
GltfDocument split_binary(const std::string& bytes, GltfFile& out) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942, kVersion = 2;
  const auto fail = [&](const std::string& message) {
    return SceneError(SourceLocation{out.file.string(), 0}, message);
  };
  const auto number = [&](std::size_t at) { return std::size_t{little_endian<std::uint32_t>(bytes.data() + at)}; };
  if (bytes.size() < kHeader + kChunkHeader) throw fail("is truncated");
  if (number(4) != kVersion) throw fail(fmt::format("has version {} of glTF, expected 2", number(4)));
  const std::size_t size = number(8);
  if (size > bytes.size()) throw fail(fmt::format("is truncated: it has {} of {} bytes", bytes.size(), size));
  GltfDocument document;
  std::string_view text;
  std::size_t end = 0;
  for (std::size_t at = kHeader; at == kHeader || at + kChunkHeader <= size;) {
    const std::size_t length = number(at), begin = at + kChunkHeader, type = number(at + 4);
    if (length > bytes.size() - begin) throw fail("is truncated: a chunk ends behind the file");
    if (at == kHeader && type != kJson) throw fail("does not begin with a JSON chunk");
    if (at == kHeader) text = std::string_view(bytes).substr(begin, length);
    if (type == kBinary && document.chunk.empty()) {
      const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data()) + begin;
      document.chunk.assign(first, first + length);
    }
    end = begin + length;
    at = begin + (length + 3) / 4 * 4;
  }
  if (end > size) {
    out.notes.push_back(
        fail(fmt::format("its header gives {} bytes, but its last chunk ends at byte {} (read to there)", size, end))
            .what());
  } else if (bytes.size() > size) {
    out.notes.push_back(
        fail(fmt::format("{} bytes behind the end that its header gives are ignored", bytes.size() - size)).what());
  }
  *document.json = parse_json(text, out.file);
  return document;
}

/// Decodes the percent signs of a URI.
std::string decode_uri(const std::string& uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      path += static_cast<char>(16 * digit(uri[i + 1]) + digit(uri[i + 2]));
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

/// Encodes a path as a URI; see decode_uri().
std::string encode_uri(const std::string& path) {
  std::string uri;
  for (const char c : path) uri += c == '%' ? "%25" : std::string(1, c);
  return uri;
}

/// Takes the notes of an imported model, and replaces the names of its images by those of files.
void take_import(json& document, GltfFile& out) {
  const json::json_pointer notes("/asset/extras/notes");
  if (document.contains(notes) && document[notes].is_array())
    for (const json& note : document[notes])
      if (note.is_string()) out.notes.push_back(fmt::format("{}: {}", out.file.string(), note.get<std::string>()));
  if (!document.contains("images") || !document["images"].is_array()) return;
  for (json& image : document["images"])
    if (image.is_object() && image.contains("uri") && image["uri"].is_string())
      image["uri"] = encode_uri(find_model_image(image["uri"].get<std::string>(), out.folder).string());
}

/// Loads the parts that lie outside of the JSON.
class ByteLoader {
 public:
  ByteLoader(GltfDocument& document, GltfFile& out) : document_(document), out_(out) {}

  void load_buffers() {
    json& buffers = list("buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const std::string part = fmt::format("buffers[{}]", i);
      out_.buffers.push_back(buffer(buffers[i], i, part));
      buffers[i] = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
    }
  }

  /// Images in buffer views must wait until the views are known; see `views`.
  void load_images() {
    json& images = list("images");
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string part = fmt::format("images[{}]", i);
      if (!images[i].is_object()) throw out_.error(part, "is not an object");
      GltfImage image;
      if (images[i].contains("uri")) {
        image = image_at(text(images[i], "uri", part), part);
        images[i] = {{"uri", "external"}};
      } else if (!images[i].contains("bufferView")) {
        throw out_.error(part, "has neither 'uri' nor 'bufferView'");
      } else {
        const json view = images[i]["bufferView"];
        if (!view.is_number_unsigned()) throw out_.error(part, "'bufferView' is not an index");
        images[i] = {{"uri", "view"}, {"name", std::to_string(view.get<std::uint64_t>())}};
      }
      out_.images.push_back(std::move(image));
    }
  }

 private:
  json& list(const char* name) {
    json& member = (*document_.json)[name];
    if (member.is_null()) member = json::array();
    if (!member.is_array()) throw out_.error(name, "is not an array");
    return member;
  }

  std::string text(const json& object, const char* name, const std::string& part) const {
    if (!object[name].is_string()) throw out_.error(part, fmt::format("'{}' is not a string", name));
    return object[name].get<std::string>();
  }

  std::vector<std::uint8_t> buffer(const json& object, std::size_t index, const std::string& part) {
    if (!object.is_object()) throw out_.error(part, "is not an object");
    const auto length = object.find("byteLength");
    if (length == object.end() || !length->is_number_unsigned())
      throw out_.error(part, "'byteLength' is not a positive integer");
    const auto size = length->get<std::uint64_t>();
    std::vector<std::uint8_t> bytes;
    if (object.contains("uri")) {
      bytes = bytes_at(text(object, "uri", part), part);
    } else if (index == 0 && !document_.chunk.empty()) {
      bytes = std::move(document_.chunk);
    } else if (is_fallback(object)) {
      return {};
    } else {
      throw out_.error(part, "has no 'uri', and the file has no binary chunk for it");
    }
    if (bytes.size() < size)
      throw out_.error(part, fmt::format("has {} bytes, but 'byteLength' is {}", bytes.size(), size));
    bytes.resize(size);
    return bytes;
  }

  /// Whether a buffer is only a fallback for compressed ones.
  static bool is_fallback(const json& object) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return false;
    return extensions->contains("EXT_meshopt_compression") || extensions->contains("KHR_meshopt_compression");
  }

  std::filesystem::path path_of(const std::string& uri, const std::string& part) {
    const std::filesystem::path path = decode_uri(uri);
    if (uri.find("://") != std::string::npos || path.is_absolute() || path.empty())
      throw out_.error(part,
                       fmt::format("'uri' is {}, expected a path relative to the file or a data URI", in_quotes(uri)));
    return out_.folder / path;
  }

  std::vector<std::uint8_t> bytes_at(const std::string& uri, const std::string& part) {
    if (uri.starts_with("data:")) return data(uri, part);
    const std::filesystem::path path = path_of(uri, part);
    out_.files.push_back(path);
    const std::string bytes = read_mesh_bytes(path, "buffer of a glTF file");
    return {bytes.begin(), bytes.end()};
  }

  GltfImage image_at(const std::string& uri, const std::string& part) {
    GltfImage image;
    if (uri.starts_with("data:")) {
      image.encoded = std::make_shared<const EncodedImage>(
          EncodedImage{data(uri, part), fmt::format("{}: {}", out_.file.string(), part)});
    } else {
      image.file = path_of(uri, part);
      out_.files.push_back(image.file);
    }
    return image;
  }

  std::vector<std::uint8_t> data(const std::string& uri, const std::string& part) const {
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || !uri.substr(0, comma).ends_with(";base64"))
      throw out_.error(part, "'uri' is a data URI without ';base64,'");
    return decode_base64(uri.substr(comma + 1));
  }

  GltfDocument& document_;
  GltfFile& out_;
};

}  // namespace

GltfDocument read_gltf_document(GltfFile& out) {
  const std::filesystem::path& file = out.file;
  const std::string bytes = is_imported_model(file) ? import_model(file) : read_mesh_bytes(file, "glTF file");
  if (bytes.empty()) throw SceneError(SourceLocation{file.string(), 0}, "is empty");
  if (bytes.starts_with("glTF")) return split_binary(bytes, out);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  const std::string_view text = bytes;
  GltfDocument document;
  *document.json = parse_json(text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0), file);
  return document;
}

void take_bytes(GltfDocument& document, GltfFile& out) {
  if (is_imported_model(out.file)) take_import(*document.json, out);
  ByteLoader loader(document, out);
  loader.load_buffers();
  loader.load_images();
}

}  // namespace sheaf
