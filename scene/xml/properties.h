// Typed access to what one object of a scene file says. It records which names the code asks for, so that the code is
// itself the list of known names and whatever is left over can be reported.
#pragma once

#include "scene/xml/spectrum_text.h"
#include "scene/xml/xml_expand.h"

#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace sheaf {

struct ReadContext;

/// An error about one element of the file. The scene without that element may be readable: see read_what_can_be().
class ElementError : public SceneError {
 public:
  ElementError(const XmlElement& element, const std::string& message)
      : SceneError(element.where, message), element_(&element) {}
  /// The same message, about this element.
  ElementError(const XmlElement& element, const SceneError& cause) : SceneError(cause.what()), element_(&element) {}
  const XmlElement& element() const { return *element_; }

 private:
  const XmlElement* element_;
};

/// Reads a <texture> element: appends a texture, or gives a spectrum if it is the same everywhere. An element is read
/// once, however often it is referred to. Throws SceneError.
using TextureReader = SpectrumInput (*)(const XmlElement& element, ReadContext& context);

/// What properties leave to the readers of whole elements.
struct ElementReaders {
  SpectrumDescription (*spectrum)(const XmlElement& element, SpectrumRole role, ReadContext& context) = nullptr;
  TextureReader texture = nullptr;  ///< the dialect's
  /// The texture that stands for another where a number is wanted.
  TextureId (*scalar_texture)(TextureId texture, ReadContext& context) = nullptr;
};

/// What all readers of one scene share.
struct ReadContext {
  const ExpandedScene& scene;
  Description& description;
  bool lenient = false;  ///< what cannot be read is left out or replaced
  ElementReaders readers = {};
  bool exchanges_checkerboards = false;                      ///< see scalar_texture()
  std::map<const XmlElement*, SpectrumInput> textures = {};  ///< read so far
  std::map<TextureId, TextureId> scalar_textures = {};       ///< made so far
  std::set<const XmlElement*> open = {};             ///< objects being read, to find references that go in circles
  std::map<const XmlElement*, MediumId> media = {};  ///< read so far
  std::map<const XmlElement*, std::uint32_t> groups = {};  ///< shape groups read so far, into Description::groups
  bool mirrors_nori_camera = true;                         ///< as ETH's course has it; see docs/scene-format.md
  bool frames_scene = false;                               ///< the camera is yet to be put where it sees the scene
  bool in_group = false;                                   ///< the shapes of a group are being read
  std::set<const XmlElement*> left_out = {};               ///< elements that are read as if they were not there
  std::map<const XmlElement*, std::string> types = {};     ///< plugins that objects are read as, in place of their own

  /// Adds a remark for the user, once.
  void note(const SourceLocation& where, const std::string& message);
  /// Says that something is read as something else, or not at all.
  void stand_in(const SourceLocation& where, const std::string& message);
  /// For the error that is being handled: throws it again unless the context is lenient. Otherwise leaves the element
  /// out that it is about, and returns true; but false if that is `around`, or known already.
  bool leave_out(const SceneError& error, const XmlElement& around);
};

/// Calls read(), which reads `element`. If the context is lenient and read() fails, that is done again without the
/// property or the nested object that is at fault, until it works; then what was left out is known to the context.
/// Returns the error that remains if the element as a whole cannot be read. Throws SceneError if not lenient.
template <class Read>
std::optional<std::string> read_what_can_be(const XmlElement& element, ReadContext& context, Read&& read) {
  for (;;) {
    try {
      read();
      return std::nullopt;
    } catch (const SceneError& error) {
      if (!context.leave_out(error, element)) return error.what();
    }
  }
}

/// The same, but what cannot be read as what it is is read as `plugin`, with those of its properties that this has.
template <class Read>
void read_or_as(const XmlElement& element, ReadContext& context, const char* plugin, Read&& read) {
  const auto error = read_what_can_be(element, context, read);
  if (!error) return;
  context.types[&element] = plugin;
  const bool done = !read_what_can_be(element, context, read);
  context.description.stand_ins.push_back(*error +
                                          (done ? " ('" + std::string(plugin) + "' stands in)" : " (left out)"));
}

/// The same for what the scene can do without: then says that the element as a whole is left out.
template <class Read> void read_or_leave_out(const XmlElement& element, ReadContext& context, Read&& read) {
  if (const auto error = read_what_can_be(element, context, read))
    context.description.stand_ins.push_back(*error + " (" + element.name + " left out)");
}

/// Legal values of a number.
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open = false;  ///< the ends themselves are illegal
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr NumberRange kNotNegative{0, std::numeric_limits<double>::infinity(), false};
inline constexpr NumberRange kUnitInterval{0, 1, false};

/// The same for all spellings of a name: `maxDepth`, `max_depth` and `maxdepth` are one.
std::string spelling_key(std::string_view name);

/// The properties and nested objects of one XML element. Names match as spelling_key() says. All functions
/// throw SceneError for a property of the wrong type or out of its range.
class Properties {
 public:
  /// Follows <ref>s. Throws SceneError for unknown elements, nameless or repeated properties, missing ids and an
  /// object that refers to itself.
  Properties(const XmlElement& object, ReadContext& context);
  ~Properties();
  Properties(const Properties&) = delete;
  Properties& operator=(const Properties&) = delete;

  const std::string& type() const { return type_; }
  const XmlElement& element() const { return object_; }
  const SourceLocation& where() const { return object_.where; }
  ReadContext& context() const { return context_; }

  /// Whether the property is there. Counts as asking for its name, not as using it.
  bool has(const char* name);
  std::optional<float> find_number(const char* name, NumberRange range = kAnyNumber);
  float number(const char* name, float default_value, NumberRange range = kAnyNumber);
  /// Also a <float> of integral value.
  int integer(const char* name, int default_value, int low, int high);
  bool boolean(const char* name, bool default_value);
  std::optional<std::string> find_string(const char* name);
  /// Whether the property is there as a string, not as another type.
  bool is_string(const char* name);
  /// Whether the property is there as a texture.
  bool is_texture(const char* name);
  /// Two numbers, or one for both.
  std::optional<Vec2f> find_vec2(const char* name);
  std::optional<Vec3f> find_vec3(const char* name);
  Vec3f vec3(const char* name, Vec3f default_value);
  /// Identity if absent.
  Transform transform(const char* name);
  std::optional<SpectrumDescription> find_spectrum(const char* name, SpectrumRole role);
  SpectrumDescription spectrum(const char* name, SpectrumDescription default_value, SpectrumRole role);
  /// A colour or a texture. Values of pictures are not checked against the role here.
  std::optional<SpectrumInput> find_spectrum_input(const char* name, SpectrumRole role);
  SpectrumInput spectrum_input(const char* name, SpectrumInput default_value, SpectrumRole role);
  /// A number or a texture; the luminance of a colour. Values of textures are not checked against the range.
  std::optional<ScalarInput> find_scalar_input(const char* name, NumberRange range);
  ScalarInput scalar_input(const char* name, ScalarInput default_value, NumberRange range);
  /// The name of the first property that is a colour or a texture, or null.
  const char* first_color() const;
  /// The one <texture> of an object that nobody has asked for, under whatever name or without one, or null. Throws
  /// SceneError if there are several.
  const XmlElement* any_texture();
  /// The same, or else the one colour.
  const XmlElement* any_texture_or_color();
  /// The file that a string property names, found and regular. Throws SceneError if it or the property is missing.
  std::filesystem::path file(const char* name);
  /// Nested objects of a kind ("bsdf"), in file order.
  std::vector<const XmlElement*> objects(const char* kind);
  /// The nested object of a kind, or null. Throws SceneError if there are several.
  const XmlElement* object(const char* kind);
  /// The nested object of a kind that goes by this name here ("interior"), or null. Throws SceneError if there are
  /// several.
  const XmlElement* named_object(const char* kind, const char* name);

  /// Properties that are documented and mean nothing here: any value is accepted.
  void ignore(std::initializer_list<const char*> names);
  /// The same for all properties whose names begin with `prefix`; returns whether there are any.
  bool ignore_prefixed(const char* prefix);
  /// Whatever is left, of an object whose parameters mean nothing here.
  void ignore_all();
  /// Throws SceneError for what nobody asked for; unknown properties are notes instead if the context is lenient.
  void reject_unused();

  /// Throws SceneError at the object, its kind and plugin named first.
  [[noreturn]] void fail(const std::string& message) const;
  /// Throws SceneError at the property, or at the object if it is absent.
  [[noreturn]] void fail_at(const char* name, const std::string& message);
  /// Throws SceneError that the object's plugin is not one of `known`.
  [[noreturn]] void fail_plugin(const std::vector<std::string>& known) const;

 private:
  /// A child element: a property with a name, or a nested object.
  struct Entry {
    std::string key;            ///< spelling_key() of the name; empty for objects
    std::string name;           ///< as in the file
    const XmlElement* written;  ///< the child itself
    const XmlElement* target;   ///< what it is or refers to
    bool used = false;
  };

  void add(const XmlElement& child);
  /// Throws unless the element has no other attributes than these; lenient contexts leave them out.
  void expect_attributes(const XmlElement& element, std::initializer_list<const char*> allowed) const;
  /// Calls parse(): its errors are about the property.
  template <class Parse> static auto parsed(const Entry& entry, Parse&& parse) {
    try {
      return parse();
    } catch (const ElementError&) { throw; } catch (const SceneError& error) {
      throw ElementError(*entry.written, error);
    }
  }
  Entry* find(const char* name);
  Entry* use(const char* name);
  /// The text of attribute `value` of a property of one of the types.
  const std::string* value(const char* name, std::initializer_list<const char*> types);
  [[noreturn]] void fail_type(const Entry& entry, const char* expected) const;
  std::string title() const;

  const XmlElement& object_;
  ReadContext& context_;
  std::string type_;
  std::vector<Entry> entries_;
  std::vector<std::string> asked_;                                 ///< property names, as the code spells them
  std::vector<std::string> asked_kinds_;                           ///< kinds of nested objects
  std::map<std::string, std::vector<std::string>> asked_objects_;  ///< names of nested objects, by kind
};

}  // namespace sheaf
