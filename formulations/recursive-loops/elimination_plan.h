// In which order bodies and closures of a model are eliminated from eq. 14, and what meets what on the way.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// A closure that a step meets.
struct Attachment {
  int strip, strips;  // of the closure conditions
  int column;         // of a body's step: of its first strip among the columns of the step
  int block;          // of a closure's step: where the two meet in the Delassus matrix, rows of the step by `strips`
  int to;             // its columns on the body that is left: index in the array of all columns, or −1 for the ground
  bool first;         // nothing was put there before
};

/// Where two attachments of a step meet in the Delassus matrix.
struct Meeting {
  int first, second;  // of a body's step: columns; of a closure's: blocks
  int first_strips, second_strips;
  int block;         // rows of the first × strips of the second, row by row
  bool first_there;  // nothing was put there before
};

/// A coupler acts on a velocity of the body that is eliminated.
struct DirectTerm {
  int freedom, column, row;  // each row is a strip where there are couplers
  double factor;
};

/// A range of one of the plan's lists.
struct Range {
  int begin = 0, end = 0;

  template <class T>
  std::span<const T> of(const std::vector<T>& list) const {
    return {list.data() + begin, list.data() + end};
  }
};

/// Freedoms of a joint, where code for one is apart from code for any number.
constexpr int any = -1;

/// A body leaves with its joint. Its columns: what unit multipliers of the closures it still meets do to it and to what
/// was eliminated behind it.
struct BodyStep {
  int body, parent;
  int v, nv;
  int first_column, columns;  // in the array of all columns, a column standing for a strip
  int responses;              // of C_kᵀ e / N_k, nv × columns, in the array of all responses
  bool untouched;             // nothing was handed to its inertia before
  bool first_to_parent;       // nor to that of the parent
  Range attachments, meetings, terms;
};

/// A closure leaves. All bodies on its loop are gone but one, `body`; its columns there are at `first_column`.
struct ClosureStep {
  int strip, strips;
  int block;               // of the closure with itself
  int weights;             // rows × strips of its factor, in an array of their own
  int body, first_column;  // −1: all is gone
  bool first_to_body;      // nothing was handed to its inertia before
  Range attachments, meetings;
};

/// A closure between bodies, and its own columns on them (in the array of all columns); −1: the ground.
struct ClosureEnds {
  int strip, strips;
  int body_a, body_b;
  int column_a, column_b;
};

/// When a closure may go.
enum class EliminationRule : unsigned char {
  path,         // after every body on its loop but the one nearest to the root
  bodies_first  // after every body from it to the ground: fills, and needs nothing of the rows but independence
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
///
/// The numeric elimination treats `width` rows of a closure side by side, as a strip; all places are counted in strips.
struct EliminationPlan {
  std::vector<int> order;  // k ≥ 0: bodies[k]; k < 0: closures[−1 − k]
  std::vector<BodyStep> bodies;
  std::vector<ClosureStep> closures;
  std::vector<Attachment> attachments;
  std::vector<Meeting> meetings;
  std::vector<DirectTerm> terms;
  std::vector<ClosureEnds> ends;                              // of the closures between bodies
  int width;                                                  // rows of a strip
  int columns = 0, responses = 0, delassus = 0, weights = 0;  // sizes of the numeric arrays
  int most_responses = 0;                                     // of one step
  double operations = 0;  // about, of one factorisation; infinite when the limit was passed, and there is no plan

  /// `width`: 1, or rows_each(model), else std::logic_error.
  explicit EliminationPlan(const Model& model, int width = 1, EliminationRule rule = EliminationRule::path,
                           double most_operations = std::numeric_limits<double>::infinity());
};

/// Of every closure and coupler, or 0 where they differ.
int rows_each(const Model& model);

}  // namespace lanc
