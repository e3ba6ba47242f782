// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The only way from the text of a scene to numbers: an object is constructed from its Section and reads each
// of its entries once, in the line that names, documents and bounds it.

#pragma once

#include <dovetail/scene/expression.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/patterns.h>
#include <deal.II/base/point.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

namespace Patterns = dealii::Patterns;

class SceneText;
struct SceneState;

/// The boundary ids that have a name. An id in digits may be a name, too, where it stands for several.
using BoundaryNames = std::map<std::string, std::vector<unsigned int>>;

/// One subsection of a scene. Reading an entry declares it: name, default, pattern and description (which
/// ends in its unit in brackets) stand in the one line that stores the value. What nobody has read when the
/// scene is complete is an error with the nearest known name (SceneText::check_all_read). A Section is a
/// cheap handle and may be kept to report errors that show later.
///
/// While the reference of all entries is written (documenting()), required entries read as T(), or "0" for
/// expressions, and check() never fails.
class Section
{
public:
  Section(std::shared_ptr<SceneText> text, std::string path);

  /// The entry @p name, or @p default_value if the scene does not have it.
  /// T: std::string, bool, int, unsigned int, double, std::vector<std::string>, std::vector<double>,
  /// std::vector<unsigned int> (lists with commas).
  /// @throw UserError if the text does not match @p pattern.
  template <typename T>
  T read(const std::string &name, const T &default_value, const std::string &description,
         const Patterns::PatternBase &pattern = *Patterns::Tools::Convert<T>::to_pattern()) const;

  /// The entry @p name, which the scene must have.
  template <typename T>
  T require(const std::string &name, const std::string &description,
            const Patterns::PatternBase &pattern = *Patterns::Tools::Convert<T>::to_pattern()) const;

  /// One of the @p choices (written as in the scene), e.g. choose("Integrate on", {"source", "both"}, 0, "…")
  /// returns the index of the chosen one; @p default_choice is the index of the default.
  unsigned int choose(const std::string &name, const std::vector<std::string> &choices,
                      unsigned int default_choice, const std::string &description) const;

  /// Formulas in x, y, z, t and @p scalars; components separated by ';'. The number of components must be one
  /// of
  /// @p n_components (a scalar or a tensor: {1, dim, dim * dim}). An empty default means zero.
  Expression read_expression(const std::string &name, const std::string &default_text,
                             const std::vector<unsigned int> &n_components, const std::string &description,
                             const std::vector<std::string> &scalars = {}) const;
  Expression require_expression(const std::string &name, const std::vector<unsigned int> &n_components,
                                const std::string &description,
                                const std::vector<std::string> &scalars = {}) const;

  /// Components separated by ';', exactly dimension() of them (a third one is accepted in 2D if it is 0).
  /// Unused components are 0.
  dealii::Point<3> read_point(const std::string &name, const dealii::Point<3> &default_value,
                              const std::string &description) const;
  dealii::Point<3> require_point(const std::string &name, const std::string &description) const;

  /// "set Domains = left, right" announces "subsection Domain left" and "subsection Domain right". Reads the
  /// plural and returns the names; each must be unique and have a subsection "<singular> NAME". While
  /// documenting: {"NAME"}.
  std::vector<std::string> announce(const std::string &plural, const std::string &singular,
                                    const std::string &description) const;

  /// A boundary reference "domain : 0, clamp".
  struct BoundaryReference
  {
    std::string domain;
    std::vector<unsigned int> ids;
  };
  BoundaryReference require_boundary(const std::string &name, const std::string &description) const;
  /// As above; an empty domain name if the entry is not set.
  BoundaryReference read_boundary(const std::string &name, const std::string &description) const;
  /// Boundaries "clamp, 3" of the domain whose section this is, or in whose section it lies.
  std::vector<unsigned int> require_boundary_ids(const std::string &name,
                                                 const std::string &description) const;
  std::vector<unsigned int> read_boundary_ids(const std::string &name, const std::string &description) const;
  /// From now on names stand for ids in all references to the boundary of the domain whose section this is,
  /// or in whose section it lies.
  void name_boundaries(const BoundaryNames &names) const;

  /// The path of an input file, which the entry @p name gives; empty if it does not. A relative one is looked
  /// for beside the file in which the entry stands, beside the scene, then in the working directory. What is
  /// found is what used.prm shows. Collective.
  std::string read_file_name(const std::string &name, const std::string &description) const;

  Section top() const; ///< the whole scene
  /// The subsection @p name below this one (created empty if the scene does not have it).
  Section subsection(const std::string &name) const;
  bool has_subsection(const std::string &name) const; ///< always while documenting
  /// While documenting: the same section under the heading "<entry> = <type>: help"; else *this.
  Section variant(const std::string &type, const std::string &help, const std::string &entry = "Type") const;

  /// Whether the scene itself gives the entry a value. An empty value counts as none, because used.prm writes
  /// the defaults too.
  bool is_set(const std::string &name) const;
  std::string peek(const std::string &name) const; ///< its text without declaring it, or ""
  /// The same of an entry in a subsection, without making that.
  std::string peek(const std::string &subsection, const std::string &name) const;
  /// Put an entry into the scene that the program has found instead of the user, in @p subsection of this
  /// section ("": this one); used.prm shows it. @p reason stands for its line in messages.
  void give(const std::string &subsection, const std::string &name, const std::string &value,
            const std::string &reason) const;
  /// The same section in a copy of the scene: what is given and read there does not show here.
  Section in_copy_of_scene() const;
  bool documenting() const;
  unsigned int dimension() const;  ///< 2 or 3, as set at the top of the scene (3 while documenting)
  const std::string &path() const; ///< e.g. "Domain left/Mesh"

  /// Throw a UserError "PATH, FILE line N: ENTRY MESSAGE". @p entry may be empty or unset (then the section's
  /// line).
  [[noreturn]] void fail(const std::string &entry, const std::string &message) const;
  /// fail() unless @p condition; never while documenting.
  void check(bool condition, const std::string &entry, const std::string &message) const;

private:
  Section(std::shared_ptr<SceneText> text, std::string path, std::string variant);

  SceneState &state() const;
  /// Note that the entry is read, and give its text: the scene's, else the default. Without a default the
  /// entry is required.
  std::string declare(const std::string &name, const std::optional<std::string> &default_text,
                      const std::string &description, const std::string &range) const;

  std::shared_ptr<SceneText> text;
  std::string section_path;
  std::string variant_name; ///< "Type = mortar" while the reference is written, else empty
};

} // namespace dovetail
