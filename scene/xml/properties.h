// The properties and nested objects of an XML element, and the state that is shared by all readers of an XML scene.
#pragma once

#include "scene/description/placement.h"
#include "scene/description/remarks.h"
#include "scene/xml/named_values.h"
#include "scene/xml/spectrum_text.h"
#include "scene/xml/xml_expand.h"

#include <map>
#include <optional>
#include <vector>

namespace sheaf {

struct Description;
struct MaterialDescription;
struct PhaseDescription;
struct ReadContext;
struct TextureDescription;

/// Reads a <texture> element: appends a texture, or returns a spectrum if the texture is constant. Each element is read
/// only once. Throws SceneError.
using TextureReader = SpectrumInput (*)(const XmlElement& element, ReadContext& context);

/// Functions of the dialect that read whole elements.
struct ElementReaders {
  SpectrumDescription (*spectrum)(const XmlElement& element, SpectrumRole role, ReadContext& context) = nullptr;
  TextureReader texture = nullptr;  ///< of the dialect
  /// The texture to use instead of `texture` for a scalar parameter.
  TextureId (*scalar_texture)(TextureId texture, ReadContext& context) = nullptr;
};

/// State that is shared by all readers of a scene.
struct ReadContext {
  const ExpandedScene& scene;
  Description& description;
  // Parts of the description, for readers that know no more of it
  Remarks& remarks;
  std::vector<TextureDescription>& texture_list;
  std::vector<MaterialDescription>& material_list;
  std::vector<PhaseDescription>& phase_list;
  ErrorSink& errors;  ///< receives errors of elements that are dropped or replaced
  ElementReaders readers = {};
  bool exchanges_checkerboards = false;                      ///< see scalar_texture()
  std::map<const XmlElement*, SpectrumInput> textures = {};  ///< already read
  std::map<TextureId, TextureId> scalar_textures = {};       ///< already made
  std::vector<const XmlElement*> open = {};                  ///< objects being read, to detect circular references
  std::map<const XmlElement*, MediumId> media = {};          ///< already read
  /// shape groups already read: index into Description::groups
  std::map<const XmlElement*, std::uint32_t> groups = {};
  bool mirrors_nori_camera = true;        ///< convention of ETH's course; see docs/scene-format/nori.md
  std::string camera = {};                ///< name or number of the camera; empty: the first
  bool needs_camera = true;               ///< a scene without one is an error
  bool frames_scene = false;              ///< an automatic camera must be placed
  std::vector<std::string> cameras = {};  ///< names of all cameras, empty where they have none; not of Nori's scenes
  bool in_group = false;                  ///< shapes of a group are being read

  /// Adds a remark for the user, without duplicates.
  void note(const SourceLocation& where, const std::string& message);
};

/// Calls read(), which reads `element`. Reports its error and returns false if the element cannot be read; it is then
/// left out.
template <class Read> bool read_or_omit(const XmlElement& element, ReadContext& context, Read&& read) {
  try {
    read();
    return true;
  } catch (const SceneError& error) {
    context.errors.report(error.about(fmt::format("<{}>", element.name)), element.name + " ignored");
    return false;
  }
}

/// Normalizes the spelling of a name: `maxDepth`, `max_depth` and `maxdepth` are equal.
std::string spelling_key(std::string_view name);

/// The properties and nested objects of one XML element. Names are compared by spelling_key(). Properties of the wrong
/// type or out of their range are reported and count as absent.
class Properties : public NamedValues {
 public:
  /// Resolves <ref>s. Reports unknown elements, unnamed or repeated properties, and missing ids. Throws SceneError for
  /// an object that refers to itself. `plugin`: replaces the type of the object; null: none.
  Properties(const XmlElement& object, ReadContext& context, const char* plugin = nullptr);
  ~Properties() override;

  const std::string& type() const { return type_; }
  const XmlElement& element() const { return object_; }
  const SourceLocation& where() const { return object_.where; }
  ReadContext& context() const { return context_; }
  std::string title() const override;

  /// Whether the property exists and is a string.
  bool is_string(const char* name);
  /// The array of a program; null if absent. Throws SceneError for other values.
  const ArrayValue* find_array(const char* name);
  /// The unused arrays whose names begin with `prefix`, in file order.
  std::vector<std::pair<std::string, const ArrayValue*>> arrays_with_prefix(std::string_view prefix);
  /// Whether the property exists and is a texture.
  bool is_texture(const char* name);
  /// Two numbers, or one for both.
  Vec2f vec2(const char* name, Vec2f default_value);
  /// Identity if absent. Reports an <animation>, and uses its first key.
  Transform transform(const char* name);
  /// A <transform> or an <animation>; identity if absent.
  Placement placement(const char* name);
  /// Whether the property exists and is an <animation>.
  bool is_animation(const char* name);
  std::optional<SpectrumDescription> find_spectrum(const char* name, SpectrumRole role);
  SpectrumDescription spectrum(const char* name, SpectrumDescription default_value, SpectrumRole role);
  /// A color or a texture. Values of images are not checked against the role here.
  std::optional<SpectrumInput> find_spectrum_input(const char* name, SpectrumRole role);
  SpectrumInput spectrum_input(const char* name, SpectrumInput default_value, SpectrumRole role);
  /// A scalar or a texture; the luminance of a color. Values of textures are not checked against the range.
  std::optional<ScalarInput> find_scalar_input(const char* name, NumberRange range);
  ScalarInput scalar_input(const char* name, ScalarInput default_value, NumberRange range);
  /// The name of the first property that is a color or a texture, or null.
  const char* first_color() const;
  /// The first unused <texture> of an object, with any name or none, or null. Reports further ones.
  const XmlElement* any_texture();
  /// any_texture(), or if null the only unused color.
  const XmlElement* any_texture_or_color();
  /// Nested objects of a kind (such as "bsdf"), in file order.
  std::vector<const XmlElement*> objects(const char* kind);
  /// The nested object of a kind, or null. Throws SceneError if there are several.
  const XmlElement* object(const char* kind);
  /// The first nested object of a kind with this name (such as "interior"), or null. Reports further ones.
  const XmlElement* named_object(const char* kind, const char* name);

  /// Makes a nested object count as absent, after an error has been reported.
  void drop_object(const XmlElement& object);

  /// Ignores all properties with the given prefix; returns whether there are any.
  bool ignore_prefixed(const char* prefix);
  /// Ignores all remaining properties and objects.
  void ignore_all();
  /// Reports unused properties and objects.
  void reject_unused();

  /// Returns the value of the object's plugin in `table`, such as the function that reads it. Throws SceneError for a
  /// plugin that is not in the table; the message lists the names of all tables.
  template <class Value, class... More>
  const Value& plugin(const NameTable<Value>& table, const NameTable<More>&... others) const {
    if (const Value* found = table.find(type_)) return *found;
    fail_plugin(table, others...);
  }
  /// As plugin(). Reports an unknown plugin, and replaces it by `substitute`, which is a name of the first table.
  template <class Value, class... More>
  const Value& plugin_or(const char* substitute, const NameTable<Value>& table, const NameTable<More>&... others) {
    if (const Value* found = table.find(type_)) return *found;
    try {
      fail_plugin(table, others...);
    } catch (const SceneError& error) { replace_plugin(error, substitute); }
    return *table.find(type_);
  }
  /// Reports an error of the object, which is read as another plugin.
  void replace_plugin(const SceneError& error, const char* substitute);
  /// Reports an error of the object, whose reading continues. `substitute`: see ErrorSink::report().
  void report(const std::string& message, SceneErrorCode code, std::string_view substitute);
  /// Throws SceneError for an unknown plugin; the message lists the names in the tables.
  template <class... Values> [[noreturn]] void fail_plugin(const NameTable<Values>&... tables) const {
    std::vector<std::string> known;
    const auto add = [&](const std::vector<std::string>& names) {
      known.insert(known.end(), names.begin(), names.end());
    };
    (add(tables.names()), ...);
    fail_plugin(std::move(known));
  }
  /// Throws SceneError: the object's plugin is not one of `known`.
  [[noreturn]] void fail_plugin(std::vector<std::string> known) const;

 private:
  /// A child element: a property with a name, or a nested object.
  struct Entry : NamedValue {
    Entry(std::string spelling, std::string given_name, const XmlElement& child, const XmlElement& referent)
        : NamedValue{std::move(given_name)}, key(std::move(spelling)), written(&child), target(&referent) {}
    std::string key;            ///< spelling_key() of the name; empty for objects
    const XmlElement* written;  ///< the child itself
    const XmlElement* target;   ///< the child itself, or the target of its <ref>
  };

  void add(const XmlElement& child);
  /// Reports attributes that are not allowed.
  void expect_attributes(const XmlElement& element, std::initializer_list<const char*> allowed) const;
  static const Entry& entry_of(const NamedValue& value) { return static_cast<const Entry&>(value); }
  Entry* find_value(const char* name) override;
  Entry* use(const char* name) { return static_cast<Entry*>(NamedValues::use(name)); }
  const char* value_kind() const override { return "property"; }
  std::string key_of(std::string_view name) const override { return spelling_key(name); }
  Number read_number(const NamedValue& value) const override;
  Number read_integer(const NamedValue& value) const override;
  bool read_boolean(const NamedValue& value) const override;
  std::string read_string(const NamedValue& value) const override;
  Vec3d read_vec3(const NamedValue& value) const override;
  std::filesystem::path find_file(const std::string& file, const NamedValue& value) const override;
  const SourceLocation& position_of(const NamedValue* value) const override;
  ErrorSink& errors() const override { return context_.errors; }
  /// The attribute `value` of a property that must have one of the types.
  const std::string& text_of(const Entry& entry, std::initializer_list<const char*> types) const;
  /// Reports a child that is ignored.
  void report_child(const XmlElement& child, const std::string& message, SceneErrorCode code);
  /// Reports an unused nested object.
  void report_unused_object(const Entry& entry);
  SceneError type_error(const Entry& entry, const char* expected) const;
  [[noreturn]] void fail_type(const Entry& entry, const char* expected) const;
  /// A number as a scalar, in its range, or a texture.
  ScalarInput scalar_of(const Entry& entry, const SpectrumInput& input, NumberRange range);
  /// The first unused child that fits, or null. Reports further ones as a second `what`.
  const XmlElement* take_first(bool (*fits)(const Entry& entry), const std::string& what);

  const XmlElement& object_;
  ReadContext& context_;
  std::string type_;
  bool is_replaced_ = false;  ///< by replace_plugin()
  std::vector<Entry> entries_;
  std::vector<std::string> queried_kinds_;                           ///< queried kinds of nested objects
  std::map<std::string, std::vector<std::string>> queried_objects_;  ///< queried names of nested objects, by kind
};

}  // namespace sheaf
