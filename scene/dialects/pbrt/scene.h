// Directives of pbrt scene files and their effects on the description.
#pragma once

#include "scene/dialects/pbrt/reader.h"

#include <span>

namespace sheaf::pbrt {

/// Reads a scene, directive by directive.
class SceneBuilder {
 public:
  using Defines = std::vector<std::pair<std::string, std::string>>;

  SceneBuilder(Description& description, const Defines& defines, ErrorSink& errors);

  /// Reads the scene file, whose relative paths refer to `folder`, and finishes the description. Throws SceneError.
  void read(const std::filesystem::path& file, const std::filesystem::path& folder);

 private:
  using Handler = void (SceneBuilder::*)(Tokens&);
  /// The section of a file in which a directive is allowed.
  enum class Section { kAnywhere, kOptions, kWorld };
  struct Directive {
    std::string_view name;
    Handler handler;
    Section section;
  };
  struct Saved {
    const char* by;  ///< directive that saved the attributes
    SourceLocation where;
    Attributes attributes;
  };

  static std::span<const Directive> directives();
  static const Directive& directive(const Token& token, const SourceLocation& where);
  void read_file(const std::filesystem::path& file, const SourceLocation& where);
  void read_directive(Tokens& tokens);
  /// Calls read() for an entity. Reports its error; the entity is then left out.
  template <class Read> void read_or_omit(const char* what, Read&& read) {
    try {
      read();
    } catch (const SceneError& error) { reader_.errors.report(error.about(what), std::string(what) + " ignored"); }
  }
  void finish();

  // directives.cpp
  std::string read_string(Tokens& tokens, const char* what);
  DirectiveArguments read_arguments(Tokens& tokens, const char* target);
  void save(const char* by);
  /// Takes the attributes that the directive `by` saved last. Throws SceneError if another one saved the last ones.
  void restore(const char* by, Attributes& attributes);

  void accelerator(Tokens& tokens);
  void area_light_source(Tokens& tokens);
  void attribute(Tokens& tokens);
  void attribute_begin(Tokens& tokens);
  void attribute_end(Tokens& tokens);
  void camera(Tokens& tokens);
  void color_space(Tokens& tokens);
  void film(Tokens& tokens);
  void import(Tokens& tokens);
  void include(Tokens& tokens);
  void integrator(Tokens& tokens);
  void light_source(Tokens& tokens);
  void make_named_material(Tokens& tokens);
  void make_named_medium(Tokens& tokens);
  void material(Tokens& tokens);
  void medium_interface(Tokens& tokens);
  void named_material(Tokens& tokens);
  void object_begin(Tokens& tokens);
  void object_end(Tokens& tokens);
  void object_instance(Tokens& tokens);
  void option(Tokens& tokens);
  void pixel_filter(Tokens& tokens);
  void sampler(Tokens& tokens);
  void shape(Tokens& tokens);
  void texture(Tokens& tokens);
  void world_begin(Tokens& tokens);

  // transforms.cpp
  /// Sets the active matrices to change(matrix).
  template <class Change> void change_transforms(Change&& change);
  void apply_transform(const Transform& transform);

  void active_transform(Tokens& tokens);
  void concat_transform(Tokens& tokens);
  void coord_sys_transform(Tokens& tokens);
  void coordinate_system(Tokens& tokens);
  void identity(Tokens& tokens);
  void look_at(Tokens& tokens);
  void reverse_orientation(Tokens& tokens);
  void rotate(Tokens& tokens);
  void scale(Tokens& tokens);
  void transform(Tokens& tokens);
  void transform_begin(Tokens& tokens);
  void transform_end(Tokens& tokens);
  void transform_times(Tokens& tokens);
  void translate(Tokens& tokens);

  Reader reader_;
  Definitions definitions_;
  SourceLocation where_;  ///< of the current directive
  std::vector<Saved> saved_;
  std::vector<std::filesystem::path> open_;  ///< files being read
  int included_ = 0;
  bool in_world_ = false;
  std::map<std::string, TransformPair, std::less<>> coordinate_systems_;
  std::map<std::string, DirectiveArguments, std::less<>> options_;  ///< camera, film etc., by directive
  TransformPair world_from_camera_;
  std::string camera_medium_;
};

}  // namespace sheaf::pbrt
