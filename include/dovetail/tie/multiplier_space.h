// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The functions against which a mortar tie tests the jump.

#pragma once

#include <dovetail/interface/interface.h>

#include <deal.II/lac/full_matrix.h>

#include <map>
#include <set>
#include <tuple>
#include <vector>

namespace dovetail {

/// The basis of the multipliers, one function psi_j for each node of the destination's faces, and the
/// equations
/// @f[ \int_\Gamma \psi_j\, (B_{dst} - B_{src} + c) \, d\Gamma = 0 . @f]
/// with the prescribed jump c (Interface::prescribed_jump), as a rule 0.
///
/// `standard`: psi_j is the trace of the destination's shape function phi_j. `dual`: on each face
/// biorthogonal, int psi_i phi_j = delta_ij int phi_j over the covered part of the face (Wohlmuth 2000), so
/// that each equation holds one destination unknown and can be solved for it. With the nodes of Gauss and
/// Lobatto these functions reproduce polynomials of degree p - 1 on affine faces (Oswald & Wohlmuth 2001).
///
/// Nodes without a function of their own: those prescribed already, those where the interface meets another
/// one that takes unknowns (cross points), and those of whose faces hardly anything is covered. On the faces
/// around such a node the others take over: its coefficient is the extrapolation of degree p - 1 of theirs,
/// so the space still holds what consistency needs. Hanging nodes have no function either: phi_j are the
/// conforming functions.
template <int dim>
class MultiplierSpace
{
public:
  using Index = dealii::types::global_dof_index;

  /// The equation of one multiplier, sum of weights times unknowns + constant = 0. Destination unknowns enter
  /// with the weight int psi_j phi_i.
  struct Row
  {
    std::map<Index, double> weights;
    double diagonal = 0; ///< of the unknown that the row belongs to
    double constant = 0; ///< int psi_j c
    /// If the destination's gradient bridges a share of a gap: its part of the weights, and what the source's
    /// gain if its own gradient bridges that share instead.
    std::map<Index, double> own_gradient, source_gain;
    std::map<Index, double> of_source; ///< the source's part of the weights, if one body has both sides
    /// Sums of the weights of each side's unknowns.
    double source_weight = 0, destination_weight = 0;
    unsigned int field = 0, component = 0; ///< of Interface::fields

    /// What the faces of another rank give to the row.
    void add(const Row &other);
    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &weights &diagonal &constant &own_gradient &source_gain &of_source &source_weight
          &destination_weight &field &component;
    }
  };

  MultiplierSpace(const Interface<dim> &interface, bool is_dual) : interface(interface), is_dual(is_dual) {}

  /// Find the nodes and the rows of the unknowns that this rank owns. Collective.
  void make(const TieConstraints &constraints, const MPI_Comm &communicator);

  std::map<Index, Row> rows; ///< by destination unknown
  /// Over all ranks: unknowns with a function, and without because of a prescribed value or another
  /// interface, of lacking cover, or on the axis.
  unsigned long n_rows = 0, n_taken = 0, n_hardly_covered = 0, n_on_axis = 0;

  /// Averages over the multipliers' functions of values at the points: for each owned row
  /// sum_q w_q phi_j^2 value_q / sum_q w_q phi_j^2 of the row's field. Collective.
  std::map<Index, double> average(const std::vector<std::vector<double>> &value_of_field_and_point,
                                  const MPI_Comm &communicator) const;

  /// The coefficients of the multipliers on the faces, from those of the rows that this rank owns.
  /// Collective.
  void set_coefficients(const std::map<Index, double> &row_coefficients, const MPI_Comm &communicator);
  bool has_coefficients() const { return are_set; }
  /// sum_j lambda_j phi_j at a point; its integrals over Gamma are those of sum_j lambda_j psi_j.
  double value(unsigned int field, unsigned int component, unsigned int q) const;

private:
  /// One component of a field on one face: the conforming functions sum_a C_ai phi_a, their coefficients.
  struct Component
  {
    unsigned int field, component; ///< of Interface::fields
    std::vector<Index> dofs;
    dealii::FullMatrix<double> C;
    std::vector<bool> has_function;
    dealii::FullMatrix<double> psi;  ///< psi_j = sum_i psi_ji phi_i, rows without a function are zero
    dealii::FullMatrix<double> mass; ///< int psi_i phi_j
    /// (i, j, c): the coefficient at node i without a function is the sum of c times that at j
    std::vector<std::tuple<unsigned int, unsigned int, double>> extrapolation;
    std::vector<double> nodal; ///< multiplier at the face's nodes
  };
  /// With the tied fields of one space of the destination.
  struct Face
  {
    unsigned int cell; ///< in Pairing::cells[destination]
    unsigned int number, space;
    std::vector<unsigned int> groups;
    std::vector<unsigned int> nodes;   ///< of the cell
    dealii::FullMatrix<double> mass;   ///< over the covered part
    std::vector<Component> components; ///< of all these fields
  };
  /// What fields add over the whole gap to the source's trace, as weights of the nodes of a cell by point of
  /// a group; empty without a gap. That of the destination may ask nodes of the source, too
  /// (Pairing::Bridge).
  struct Extension
  {
    std::vector<double> of_source, of_destination, of_destination_at_source, shares;
  };
  struct Shares
  {
    double covered = 0, full = 0, integral = 0;

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &covered &full &integral;
    }
  };

  std::set<unsigned int> spaces() const;
  unsigned int first_shape(const Face &face) const;
  const dealii::FiniteElement<dim> &element(const Face &face) const;
  void find_nodes(Face &face) const;
  void find_faces();
  void find_faces(unsigned int space);
  void find_components(Face &face, const std::vector<Index> &cell_dofs) const;
  std::map<Index, bool> decide(const TieConstraints &constraints, const MPI_Comm &communicator);
  void add_full_masses(std::map<Index, Shares> &shares) const;
  std::set<Index> cross_points() const;
  dealii::FullMatrix<double> extend(const Face &face, Component &component,
                                    const std::vector<unsigned int> &kept) const;
  void make_functions(Face &face) const;
  dealii::FullMatrix<double> node_coordinates(const Face &face) const;
  dealii::FullMatrix<double> polynomials(const Face &face, unsigned int degree) const;
  void add_rows(const Face &face, double t, std::map<Index, Row> &to) const;
  Extension extension(const typename Pairing<dim>::Group &group, unsigned int field) const;
  void add_source(const Face &face, const typename Pairing<dim>::Group &group, const Extension &extension,
                  const Component &component, unsigned int j, double t, Row &row) const;
  void add_own_gradient(const typename Pairing<dim>::Group &group, unsigned int field, unsigned int component,
                        const std::vector<double> &destination_weight,
                        const std::vector<double> &source_weight, Row &row) const;

  const Interface<dim> &interface;
  const bool is_dual;
  dealii::AffineConstraints<double> hanging; ///< of the destination's own numbering
  std::vector<Face> faces;
  std::map<unsigned int, std::vector<unsigned int>> face_of_point; ///< by space
  std::map<Index, unsigned int> owner_of;                          ///< of unknowns on this rank's faces
  bool are_set = false;
};

} // namespace dovetail
