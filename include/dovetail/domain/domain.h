// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One body: its mesh, its space, its material and what is prescribed on it.

#pragma once

#include <dovetail/domain/body_force.h>
#include <dovetail/domain/cell_layout.h>
#include <dovetail/domain/cell_memory.h>
#include <dovetail/domain/condition.h>
#include <dovetail/domain/condition_places.h>
#include <dovetail/domain/constraint_lines.h>
#include <dovetail/domain/cover.h>
#include <dovetail/domain/last_good.h>
#include <dovetail/domain/measure.h>
#include <dovetail/domain/mesh.h>
#include <dovetail/domain/weak_penalties.h>
#include <dovetail/material/material.h>

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/trilinos_vector.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// A body Omega with its own mesh and DoFHandler. A field has the Lagrange element of degree p unless it asks
/// for another one; cell_layout.h says how the local unknowns of a cell and shape functions are ordered.
///
/// The unknowns of the domain are numbered field by field; in the vector of all unknowns they follow those of
/// the domains before it, from first_dof() on.
template <int dim>
class Domain
{
public:
  /// Reads `subsection Domain NAME`; collective.
  Domain(const std::string &name, const Section &section, const Material<dim> &material,
         const Toggles &toggles, const MPI_Comm &communicator);
  /// The same body on the same mesh, which it shares, with elements of another degree; the mapping stays.
  /// Its conditions are read again. Collective. @pre It lives no longer than @p other keeps its mesh.
  Domain(const Domain &other, unsigned int degree, const Toggles &toggles, const MPI_Comm &communicator);
  ~Domain();

  using cell_iterator = typename dealii::DoFHandler<dim>::active_cell_iterator;

  const std::string name;
  const Section section; ///< for error messages
  const Material<dim> &material;
  const Measure<dim> measure; ///< of all integrals over the body and its boundary
  const unsigned int degree;

  const Mesh<dim> &mesh() const { return *triangulation; }
  const dealii::Mapping<dim> &mapping() const { return *cell_mapping; }
  unsigned int mapping_degree() const { return degree_of_mapping; }
  const dealii::DoFHandler<dim> &dof_handler() const { return dofs; }
  const CellLayout<dim> &layout() const { return *cell_layout; }
  /// The Lagrange element of the domain's degree.
  const dealii::FiniteElement<dim> &scalar_element() const { return cell_layout->element_of_space(0); }

  /// All cells have one shape, and so have their faces.
  dealii::ReferenceCell cell_shape() const { return scalar_element().reference_cell(); }
  dealii::ReferenceCell face_shape() const { return cell_shape().face_reference_cell(0); }
  bool has_simplices() const { return cell_shape().is_simplex(); } ///< triangles or tetrahedra

  const std::vector<Field> &fields() const { return material.fields(); }
  unsigned int n_components() const { return material.n_components(); }
  /// The rule of all integrals over cells in the balance: degree + 1 points per direction.
  dealii::Quadrature<dim> cell_quadrature() const;
  unsigned int dofs_per_cell() const { return cell_layout->size(); }

  /// Global unknowns of a cell in the order component, node. @p indices is resized.
  void cell_dofs(const cell_iterator &cell, std::vector<dealii::types::global_dof_index> &indices) const;
  /// The unknowns of a cell as the domain's DoFHandler sees it.
  cell_iterator dof_cell(const typename dealii::Triangulation<dim>::active_cell_iterator &cell) const
  {
    return cell_iterator(&*triangulation, cell->level(), cell->index(), &dofs);
  }

  const std::vector<std::unique_ptr<Condition<dim>>> &conditions() const { return all_conditions; }
  bool has_conditions_by_fields() const; ///< their toggles look at fields at the last good state

  /// A boundary face of an owned or a ghost cell. Collected once, so that nothing else walks over all cells
  /// for them.
  struct BoundaryFace
  {
    typename dealii::Triangulation<dim>::active_cell_iterator cell;
    unsigned int number;
    dealii::types::boundary_id id;
  };
  const std::vector<BoundaryFace> &boundary_faces() const { return faces; }

  /// The unit normal of the plane of a face on which a condition constrains normal components; components
  /// that are rounding are zero.
  const dealii::Tensor<1, dim> &plane_normal(const BoundaryFace &face) const
  {
    return normals.at({face.cell->active_cell_index(), face.number});
  }
  /// The nodes of conditions that act at a point, on the rank that owns them.
  const std::map<const Condition<dim> *, NodeOfCell<dim>> &nodes_of_points() const { return point_nodes; }
  /// Whether a strong condition constrains a component of its field at the nodes of a face.
  bool constrains(const Condition<dim> &condition, const BoundaryFace &face, unsigned int component) const;

  /// Per component, flattened over the fields; nullptr if the scene does not give it.
  struct Given
  {
    std::map<std::string, Expression> expressions;
    const Expression *find(const std::string &field) const
    {
      const auto found = expressions.find(field);
      return found == expressions.end() ? nullptr : &found->second;
    }
  };
  const Given &source() const { return given_source; }
  const BodyForce<dim> &body_force() const { return force; }
  const Given &initial() const { return given_initial; } ///< rates too, by Field::rate
  const Given &exact() const { return given_exact; }

  double typical_length() const { return length; }     ///< the diagonal of the body's bounding box
  dealii::Point<dim> centre() const { return middle; } ///< of that box
  /// Whether a point lies on the axis of an axisymmetric scene, up to rounding.
  bool is_on_axis(const dealii::Point<dim> &X) const
  {
    return measure.is_axisymmetric() && X[0] <= 1e-10 * length;
  }
  bool reaches_axis() const { return measure.is_axisymmetric() && smallest_x <= 1e-10 * length; }

  std::set<dealii::types::boundary_id> boundary_ids() const; ///< of the whole mesh
  /// @throw UserError if the mesh has no boundary with this id; lists those it has with their areas.
  void check_boundary_id(dealii::types::boundary_id id, const Section &asking,
                         const std::string &entry) const;

  /// Of all relevant unknowns, in the numbering of the DoFHandler; closed.
  dealii::AffineConstraints<double> hanging_nodes() const;
  /// Hanging nodes, u_r = 0 on the axis of an axisymmetric scene and prescribed values at time @p t in global
  /// unknowns, for those that this rank owns.
  void add_constraints(double t, ConstraintLines &lines) const;

  bool can_refine() const; ///< cells of its mesh can be divided one by one

  /// Divide the marked ones of the owned cells (by active cell index) and as many around them as that needs,
  /// and number the unknowns anew. @p ghosted holds the domain's unknowns in the numbering of its DoFHandler.
  /// Collective. @return the same function on the new mesh, owned entries. @pre can_refine()
  dealii::TrilinosWrappers::MPI::Vector refine(const std::vector<bool> &marked,
                                               const dealii::TrilinosWrappers::MPI::Vector &ghosted);

  /// Of all unknowns, the first that is of this domain. @pre number_from(), which Numbering calls
  dealii::types::global_dof_index first_dof() const
  {
    Assert(begin_of_unknowns != dealii::numbers::invalid_dof_index, dealii::ExcNotInitialized());
    return begin_of_unknowns;
  }
  void number_from(const dealii::types::global_dof_index index) { begin_of_unknowns = index; }
  /// How many unknowns each field has over all ranks; those of one field follow those of the one before.
  const std::vector<dealii::types::global_dof_index> &n_dofs_of_fields() const { return sizes_of_fields; }

  std::vector<Cover<dim>> covers; ///< of its boundary, by interfaces
  WeakPenalties weak_penalties;   ///< of values that are prescribed weakly, set at the beginning of a step

  LastGood last_good; ///< for conditions whose toggles look at fields

  std::unique_ptr<CellMemory<dim>> memory; ///< nullptr if the material remembers nothing

private:
  void read_given(const Section &section);
  void read_initial_rate(const Section &initial, const Field &field);
  void read_conditions(const Section &section, const Toggles &toggles);
  void check_conditions() const;
  void place_conditions(const MPI_Comm &communicator);
  void add_hanging_nodes(ConstraintLines &lines) const;
  void add_values(double t, ConstraintLines &lines) const;
  void add_planes(double t, ConstraintLines &lines) const;
  void add_axis(ConstraintLines &lines) const;
  std::unique_ptr<dealii::FEValues<dim>> nodes_of(unsigned int component) const;
  bool touches_axis(const BoundaryFace &face) const; ///< with a vertex
  void collect_boundary_faces(const MPI_Comm &communicator);
  void choose_elements();
  void measure_box(const MPI_Comm &communicator);
  void distribute_dofs();
  void make_memory();
  void divide_cells();

  std::unique_ptr<Mesh<dim>> triangulation;
  std::unique_ptr<dealii::Mapping<dim>> cell_mapping;
  unsigned int degree_of_mapping = 1;
  std::unique_ptr<CellLayout<dim>> cell_layout;
  dealii::DoFHandler<dim> dofs;
  dealii::types::global_dof_index begin_of_unknowns = dealii::numbers::invalid_dof_index;
  std::vector<dealii::types::global_dof_index> sizes_of_fields;
  std::vector<std::unique_ptr<Condition<dim>>> all_conditions;
  std::vector<BoundaryFace> faces;
  PlaneNormals<dim> normals;
  std::map<const Condition<dim> *, NodeOfCell<dim>> point_nodes;
  std::map<dealii::types::boundary_id, double> measures; ///< of the parts of the boundary, over all ranks
  Given given_source, given_initial, given_exact;
  const BodyForce<dim> force;
  double length = 0, smallest_x = 0;
  dealii::Point<dim> middle;
  bool shares_mesh = false; ///< which belongs to the domain of another degree
};

} // namespace dovetail
