// In which order bodies and closures of a model are eliminated from eq. 14, and what meets what on the way.
#pragma once

#include <cstdint>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// The rows of one closure among the columns of a step.
struct Attachment {
  int row, rows;  // of the closure conditions
  int column;     // of its first row among the columns of the step
  int to;         // its columns on the body that is left: index in the array of all columns, or −1 for the ground
};

/// Where two attachments of a step meet in the Delassus matrix: rows × columns entries of it at `slot`, `stride` apart.
struct Meeting {
  int first, second;  // columns of the step
  int rows, columns;
  int slot, stride;
};

/// A coupler acts on a velocity of the body that is eliminated.
struct DirectTerm {
  int freedom, column, row;
  double factor;
};

/// A range of one of the plan's lists.
struct Range {
  int begin = 0, end = 0;
};

/// A body leaves with its joint. Its columns: what unit multipliers of the closures it still meets do to it and to what
/// was eliminated behind it.
struct BodyStep {
  int body, parent;
  int v, nv;
  int first_column, columns;  // in the array of all columns
  int responses;              // of C_kᵀ e / N_k, nv × columns, in the array of all responses
  Range attachments, meetings, terms;
};

/// A closure leaves: `rows` rows of the Delassus matrix at `panel`, `stride` apart; first its own columns, then those
/// of the closures it meets. All bodies on its loop are gone but one, `body`; with it, the columns at `first_column`.
struct ClosureStep {
  int row, rows;
  int panel, stride;
  int body, first_column;  // −1: all is gone
  Range attachments, meetings;
};

/// Symbolic elimination of a model, made once.
///
/// Path rule: bodies leave leaf first, a closure not before every body on its loop but the one nearest to the root on
/// both sides (of a coupler: every body whose velocity it acts on, up to one that carries them all). So closures meet
/// closures and at most one body, no body ever meets another but its parent, and what is left moves the loop rigidly:
/// a combination of rows with a vanishing pivot meets nothing that is left and can be dropped. Among what the rule
/// admits the node with the least rows to meet goes first (minimum degree).
///
/// A chain of loops, a ladder, a tree of loops: linear in bodies and loops. Tested by
/// tests/formulations/recursive_loops_test.cpp.
struct EliminationPlan {
  std::vector<int> order;  // k ≥ 0: bodies[k]; k < 0: closures[−1 − k]
  std::vector<BodyStep> bodies;
  std::vector<ClosureStep> closures;
  std::vector<Attachment> attachments;
  std::vector<Meeting> meetings;
  std::vector<DirectTerm> terms;
  std::vector<int> column_of_end_a,
      column_of_end_b;                        // per closure row on bodies, in the array of all columns; −1 ground
  int columns = 0, responses = 0, panel = 0;  // sizes of the numeric arrays
  int scratch = 0;                            // most responses, or columns of a panel, of one step
  double operations = 0;                      // about, of one factorisation

  explicit EliminationPlan(const Model& model);
};

}  // namespace lanc
