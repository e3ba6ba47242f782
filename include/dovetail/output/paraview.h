// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Pictures: files that ParaView opens.

#pragma once

#include <dovetail/output/interface_surface.h>
#include <dovetail/scene/units.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Writes `<Directory>/solution.pvd`: time steps, and in each of them one block per domain and per interface,
/// named as in the scene. Each block of a step is one file in `<Directory>/steps`, and a .vtm file there
/// holds them together.
///
/// A domain shows the quantities that `Fields` names and that its material can have (quantity.h), an
/// interface what InterfaceSurface lists. Quantities that are known only on the boundary make one more block,
/// "NAME boundary". Everything is shown on the undeformed bodies: "Warp By Vector" with displacement deforms
/// them.
///
/// With the `Units` of the scene, arrays carry theirs.
///
/// The points of an interface that face nothing, if there are any, stand in `<Directory>/uncovered_NAME.vtu`.
///
/// With `Paraview = false` nothing is allocated or written.
template <int dim>
class Paraview
{
public:
  /// Reads `Fields` and `Paraview` of the section `Output`.
  Paraview(const Section &output, const Model<dim> &model, const std::string &directory);
  ~Paraview();

  bool is_on() const { return writes; }
  /// Interfaces are left out: what they transmit is known of solutions only.
  void show_bodies_alone() { shows_interfaces = false; }
  /// In the series the number of a step takes the place of its time, which may fall.
  void number_steps() { numbers_steps = true; }

  /// Add a time step, or write the last one anew if it has this time; solution.pvd is whole after each.
  /// Collective; @p solution is ghosted. @p reactions: of this solution, if they are needed. @pre The model
  /// is paired. @throw UserError or OutputError on all ranks if a file cannot be written.
  void write(double time, const Vector &solution, const Reactions<dim> *reactions = nullptr);
  bool needs_reactions() const;
  bool has_motion() const;                           ///< some quantity asks for velocities
  void set_velocity(const Vector *velocity);         ///< before write(), ghosted, by reference
  unsigned int n_files() const { return n_written; } ///< so far, those written anew counted again

  void forget_meshes() { blocks.clear(); } ///< they have changed

  /// Of the steps that solution.pvd lists; a run that goes on adds its own to those.
  const std::vector<double> &times_of_steps() const { return times; }
  void go_on_from(const std::vector<double> &times_so_far);

private:
  struct Block
  {
    std::string name;                               ///< as in the scene
    std::string stem;                               ///< of its files
    const Domain<dim> *domain = nullptr;            ///< or
    std::unique_ptr<InterfaceSurface<dim>> surface; ///< of an interface
    QuantityList<dim> quantities;                   ///< of a domain
    bool is_of_boundary = false;                    ///< it shows the faces of the domain
  };

  void read_fields(const Section &output);
  void add_unit(const std::string &array, const std::string &in_si);
  void add_block(const Domain<dim> &domain, bool is_of_boundary);
  PieceOfPicture show(Block &block, const dealii::DataOutBase::VtkFlags &flags, double time,
                      const Vector &solution) const;
  static bool has_lagrange_cells(const Block &block);
  void prepare(); ///< blocks and the directory, before the first step is written
  void name_files();
  void show_uncovered_points(unsigned int interface);
  template <typename Show>
  void write_picture(const std::string &file, const dealii::DataOutBase::VtkFlags &flags, const Show &show);
  void write_index_of_step() const;
  void write_series() const;
  void check(const Obstacle &obstacle) const;

  const Model<dim> &model;
  const std::string directory;
  bool writes = true, shows_interfaces = true, numbers_steps = false;
  std::vector<std::unique_ptr<Quantity<dim>>> quantities; ///< of all domains
  std::map<const Domain<dim> *, QuantityList<dim>> quantities_of;
  std::optional<Units> given_units;         ///< of the scene
  std::map<std::string, std::string> units; ///< in these, of arrays by their names
  std::vector<Block> blocks;
  std::vector<double> times;
  unsigned int n_written = 0;
};

} // namespace dovetail
