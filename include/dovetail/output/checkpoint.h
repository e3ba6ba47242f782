// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a run goes on from after it has ended or was ended (doc/theory/checkpoint.md).

#pragma once

#include <dovetail/output/record_file.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/system/model.h>
#include <dovetail/system/vector.h>

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace dovetail {

/// What the parts of a run put into a checkpoint, each under a name of its own, beside what domains and
/// interfaces remember.
struct SavedState
{
  nlohmann::ordered_json numbers;        ///< the same on all ranks, and finite
  std::map<std::string, Vector> vectors; ///< of all unknowns, owned
};

/// Writes the state after a good step. Collective. @return what stands in the way
template <int dim>
Obstacle write_checkpoint(const std::string &file, const SceneText &text, const Model<dim> &model,
                          const SavedState &state);

/// Reads a checkpoint. All functions are collective and throw the same UserError on all ranks.
template <int dim>
class Checkpoint
{
public:
  explicit Checkpoint(const std::string &file, const MPI_Comm &communicator);

  /// @throw UserError if the scene differs from that of the checkpoint in what may not change
  void check_scene(const SceneText &text) const;
  /// @throw UserError if the meshes differ. @pre The model is paired.
  void check_meshes(const Model<dim> &model) const;

  const nlohmann::ordered_json &numbers() const { return file.header()["numbers"]; }
  unsigned int n_ranks() const { return file.header()["ranks"]; } ///< that wrote it
  /// @param layout a vector of all unknowns, owned
  std::map<std::string, Vector> vectors(const Model<dim> &model, const Vector &layout) const;
  /// What laws remember at the points of cells and interfaces.
  void restore_memory(Model<dim> &model) const;
  /// Penalties of the last good step. @pre The step has begun.
  void restore_penalties(Model<dim> &model) const;

private:
  void read_unknowns(const Model<dim> &model, const std::string &record, const Domain<dim> &domain,
                     std::map<std::string, Vector> &vectors,
                     const std::vector<dealii::types::global_dof_index> &unknowns,
                     const std::vector<dealii::types::global_dof_index> &places) const;
  std::vector<std::vector<double>> read_cells(const std::string &record, const Domain<dim> &domain) const;
  std::vector<double> read_points(const std::string &record, const Interface<dim> &interface) const;
  [[noreturn]] void refuse_mesh(const std::string &what) const;

  const std::string name;
  const MPI_Comm communicator;
  const RecordReader file;
};

/// Entries that a run that goes on may have changed, by path.
bool may_change(const std::string &path);

} // namespace dovetail
