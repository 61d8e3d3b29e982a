#include "lib/model/model.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "lib/model/validate.h"
#include "lib/spatial/eigen.h"

namespace lanc {

namespace {

FrameTurn turn_of(const Eigen::Matrix3d& X) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const auto stands = [&](const auto& a, const auto& b, const auto& c) {
    return X.col(0) == a && X.col(1) == b && X.col(2) == c;
  };
  if (stands(x, y, z)) return FrameTurn::none;
  if (stands(y, z, x)) return FrameTurn::yzx;
  if (stands(z, x, y)) return FrameTurn::zxy;
  return FrameTurn::other;
}

}  // namespace

/// Turns a specification into Model::Data; one use.
class ModelBuilder {
 public:
  explicit ModelBuilder(ModelSpec spec) : spec_(std::move(spec)) {}

  std::shared_ptr<const Model::Data> build() {
    check_globals();
    sort_bodies();
    data_->spec = std::move(spec_);  // keeps the bodies where they are in memory, so the index of names stays valid
    for (int i = 0; i < static_cast<int>(data_->spec.bodies.size()); ++i) add_link(i);
    mark_leaves_and_last_siblings();
    add_springs_and_wrenches();
    add_closures();
    find_length();
    find_singular_inertia();
    return data_;
  }

 private:
  using Index = Model::Data::Index;

  void check_globals() {
    if (!spec_.gravity.allFinite()) throw InputError(spec_.place, "gravity is not finite; give three numbers in m/s²");
    if (spec_.length && !(std::isfinite(*spec_.length) && *spec_.length > 0))
      throw InputError(spec_.place, "the model's length must be a positive number of metres");
    for (const BodySpec& body : spec_.bodies) validate(body);
    for (const JointSpec& joint : spec_.joints) validate(joint);
    for (const PointSpringSpec& spring : spec_.springs) validate(spring);
    for (const WrenchSpec& wrench : spec_.wrenches) validate(wrench);
  }

  template <class Item>
  static Index index_by_name(const std::vector<Item>& items, const char* what) {
    Index index;
    index.reserve(items.size());
    for (int i = 0; i < static_cast<int>(items.size()); ++i)
      if (!index.emplace(items[i].name, i).second)
        throw InputError(items[i].place, fmt::format("two {} are called '{}'; rename one", what, items[i].name));
    return index;
  }

  static int find(const Index& index, const std::string& name, const Place& place, const std::string& who) {
    const auto found = index.find(name);
    if (found == index.end())
      throw InputError(place, fmt::format("{}: there is no body '{}'; define it or mend the name", who, name));
    return found->second;
  }

  /// Puts parents before children and joint i beside body i, keeping the given order where it is possible.
  void sort_bodies() {
    data_->body_index = index_by_name(spec_.bodies, "bodies");
    index_by_name(spec_.joints, "joints");
    index_by_name(spec_.springs, "springs");
    const int n = static_cast<int>(spec_.bodies.size());
    std::vector<int> joint_of(n, -1), parent(n, ground);
    for (int j = 0; j < static_cast<int>(spec_.joints.size()); ++j) {
      const JointSpec& joint = spec_.joints[j];
      const std::string who = "joint '" + joint.name + "'";
      const bool beside = j < n && spec_.bodies[j].name == joint.body;  // spares a search in the usual order
      const int body = beside ? j : find(data_->body_index, joint.body, joint.place, who);
      if (joint_of[body] >= 0)
        throw InputError(joint.place,
                         fmt::format("{}: body '{}' already hangs on joint '{}'; a tree has one joint per body", who,
                                     joint.body, spec_.joints[joint_of[body]].name));
      joint_of[body] = j;
      if (!joint.parent.empty()) parent[body] = find(data_->body_index, joint.parent, joint.place, who);
    }
    for (int i = 0; i < n; ++i)
      if (joint_of[i] < 0)
        throw InputError(spec_.bodies[i].place,
                         fmt::format("body '{}' has no joint; add one that carries it (a free joint "
                                     "for a floating body)",
                                     spec_.bodies[i].name));

    std::vector<int> order, mark(n, 0);  // mark: 1 on the current path, 2 placed
    order.reserve(n);
    std::vector<int> path;
    for (int i = 0; i < n; ++i) {
      for (int k = i; k != ground && mark[k] != 2; k = parent[k]) {
        if (mark[k] == 1)
          throw InputError(spec_.joints[joint_of[k]].place,
                           fmt::format("body '{}' is its own ancestor: the joints form a cycle; a tree has none",
                                       spec_.bodies[k].name));
        mark[k] = 1;
        path.push_back(k);
      }
      for (; !path.empty(); path.pop_back()) {
        mark[path.back()] = 2;
        order.push_back(path.back());
      }
    }
    apply_order(order, joint_of, parent);
  }

  void apply_order(const std::vector<int>& order, const std::vector<int>& joint_of, const std::vector<int>& parent) {
    const int n = static_cast<int>(order.size());
    bool sorted = true;
    for (int k = 0; k < n; ++k) sorted = sorted && order[k] == k && joint_of[k] == k;
    if (sorted) {  // as generators and most files give it; moving a million bodies costs more than all checks
      parent_ = parent;
      return;
    }
    std::vector<BodySpec> sorted_bodies;
    std::vector<JointSpec> sorted_joints;
    sorted_bodies.reserve(n), sorted_joints.reserve(n);
    std::vector<int> new_index(n);
    for (int k = 0; k < n; ++k) new_index[order[k]] = k;
    for (const int i : order) {
      parent_.push_back(parent[i] == ground ? ground : new_index[parent[i]]);
      sorted_bodies.push_back(std::move(spec_.bodies[i]));
      sorted_joints.push_back(std::move(spec_.joints[joint_of[i]]));
    }
    spec_.bodies = std::move(sorted_bodies);
    spec_.joints = std::move(sorted_joints);
    data_->body_index = index_by_name(spec_.bodies, "bodies");
  }

  void add_link(int i) {
    const BodySpec& body = data_->spec.bodies[i];
    const JointSpec& joint = data_->spec.joints[i];
    const JointTraits& traits = joint.kind.traits();
    const Eigen::Matrix3d Q = joint_axes(joint);  // joint axes in body axes
    const Eigen::Matrix3d to_parent_axes =
        parent_[i] == ground ? Eigen::Matrix3d::Identity() : to_eigen(data_->body_axes[parent_[i]]);

    Link link;
    link.parent = parent_[i];
    link.kind = joint.kind;
    link.pitch = joint.pitch;
    const Eigen::Matrix3d X = to_parent_axes * joint.frame.rotation * Q;
    link.X = from_eigen(X);
    link.turn = parent_[i] == ground ? FrameTurn::none : turn_of(X);
    link.o = from_eigen(Eigen::Vector3d(to_parent_axes * joint.frame.position));
    const Eigen::Vector3d c = Q.transpose() * body.com;
    const Eigen::Matrix3d I = Q.transpose() * body.inertia * Q;
    const Eigen::Matrix3d J = I + body.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    link.inertia = {body.mass, from_eigen(Eigen::Vector3d(body.mass * c)), symmetric_from_eigen(J)};
    link.weight = from_eigen(Eigen::Vector3d(body.mass * data_->spec.gravity));
    link.q = data_->nq;
    link.v = data_->nv;
    if (joint.motion) {
      link.drive = static_cast<int>(data_->motions.size());
      try {
        data_->motions.push_back(PrescribedMotion::create(*joint.motion));
      } catch (const InputError& error) {
        throw InputError(joint.place, "joint '" + joint.name + "': " + error.what());
      }
      data_->body_of_drive.push_back(i);
    } else {
      link.nq = traits.nq;
      link.nv = traits.nv;
    }
    link.angle = static_cast<int>(data_->angles.size());
    for (int k = 0; k < traits.nq; ++k)
      if (is_angle(traits, k)) data_->angles.push_back(link.drive < 0 ? link.q + k : -1 - link.drive);
    for (int k = 0; k < link.nv; ++k) {
      data_->body_of_velocity.push_back(i);
      data_->column_kind.push_back(traits.columns[k]);
      const double armature = joint.coordinates.empty() ? 0.0 : joint.coordinates[k].armature;
      data_->armature.push_back(armature);
      data_->has_armature |= armature > 0;
    }
    for (int k = 0; k < static_cast<int>(joint.coordinates.size()); ++k) {
      const CoordinateSpec& c_spec = joint.coordinates[k];
      if (c_spec.stiffness != 0 || c_spec.damping != 0 || c_spec.friction_positive != 0 ||
          c_spec.friction_negative != 0 || c_spec.torque != 0 || (joint.motion && c_spec.armature != 0))
        data_->passive.push_back({i, k, c_spec});
    }
    data_->nq += link.nq;
    data_->nv += link.nv;
    data_->body_axes.push_back(from_eigen(Eigen::Matrix3d(Q.transpose())));
    data_->links.push_back(link);
  }

  void mark_leaves_and_last_siblings() {
    std::vector<bool> met(data_->links.size() + 1, false);
    for (auto link = data_->links.rbegin(); link != data_->links.rend(); ++link) {
      link->last_sibling = !met[link->parent + 1];
      met[link->parent + 1] = true;
      if (link->parent != ground) data_->links[link->parent].leaf = false;
    }
  }

  void add_springs_and_wrenches() {
    const auto body = [&](const std::string& name, const Place& place, const std::string& who) {
      return name.empty() ? ground : find(data_->body_index, name, place, who);
    };
    const auto in_joint_axes = [&](int i, const Eigen::Vector3d& point) {
      return i == ground ? from_eigen(point) : data_->body_axes[i] * from_eigen(point);
    };
    for (const PointSpringSpec& s : data_->spec.springs) {
      const std::string who = "spring '" + s.name + "'";
      const int a = body(s.body_a, s.place, who), b = body(s.body_b, s.place, who);
      data_->springs.push_back(
          {a, b, in_joint_axes(a, s.point_a), in_joint_axes(b, s.point_b), s.stiffness, s.damping, s.rest_length});
    }
    for (const WrenchSpec& w : data_->spec.wrenches)
      data_->wrenches.push_back(
          {find(data_->body_index, w.body, w.place, "wrench"), {from_eigen(w.moment), from_eigen(w.force)}});
  }

  void add_closures() {
    const auto coordinate = [&](const CouplerSpec::Term& term, const Place& place, const std::string& who) {
      const auto joint = std::find_if(data_->spec.joints.begin(), data_->spec.joints.end(),
                                      [&](const JointSpec& j) { return j.name == term.joint; });
      if (joint == data_->spec.joints.end())
        throw InputError(place, fmt::format("{}: there is no joint '{}'; define it or mend the name", who, term.joint));
      const Link& link = data_->links[joint - data_->spec.joints.begin()];
      const JointTraits& traits = link.kind.traits();
      if (link.drive >= 0)
        throw InputError(place, fmt::format("{}: the motion of joint '{}' is prescribed already; couple one that is "
                                            "free, or give the coupler a motion",
                                            who, term.joint));
      if (!traits.rates_are_velocities() || term.coordinate < 0 || term.coordinate >= traits.nv)
        throw InputError(
            place, fmt::format("{}: joint '{}' ({}) has no such coordinate to couple", who, term.joint, traits.name));
      return Coupler::Term{link.q + term.coordinate, link.v + term.coordinate, term.factor};
    };
    data_->closures = build_closures(
        data_->spec, {[&](const std::string& name, const Place& place, const std::string& who) {
                        return name.empty() ? ground : find(data_->body_index, name, place, who);
                      },
                      [&](int body) { return body == ground ? identity3<double>() : data_->body_axes[body]; },
                      coordinate, [&](int v) { return data_->column_kind[v] == ColumnKind::translation; }});
  }

  void find_length() {
    data_->gravity = from_eigen(data_->spec.gravity);
    if (data_->spec.length) {
      data_->length = *data_->spec.length;
      return;
    }
    double sum = 0;
    int count = 0;
    for (const JointSpec& joint : data_->spec.joints)
      if (joint.frame.position.norm() > 0) sum += joint.frame.position.norm(), ++count;
    if (count > 0) data_->length = sum / count;
  }

  /// A body is safe when its smallest principal inertia is not lost against the largest of the mechanism: 1e-7 of it,
  /// so that whoever mixes both keeps half of the digits, and a tenth to spare for errors that grow along a chain.
  /// Everything else is checked at run time (has_singular_inertia).
  void find_singular_inertia() {
    double largest = 0;
    for (const Link& link : data_->links) {
      const Sym3<double>& J = link.inertia.J;
      largest = std::max(largest, J.xx + J.yy + J.zz + link.inertia.mass * dot(link.o, link.o));
    }
    for (int i = 0; i < static_cast<int>(data_->links.size()); ++i) {
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
      solver.computeDirect(data_->spec.bodies[i].inertia, Eigen::EigenvaluesOnly);
      if (!(data_->links[i].inertia.mass > 0 && solver.eigenvalues()[0] > 1e-7 * largest))
        data_->singular_inertia_body = i;
    }
  }

  ModelSpec spec_;
  std::vector<int> parent_;
  std::shared_ptr<Model::Data> data_ = std::make_shared<Model::Data>();
};

Model Model::build(ModelSpec spec) {
  Model model;
  model.data_ = ModelBuilder(std::move(spec)).build();
  return model;
}

std::optional<int> Model::find_body(std::string_view name) const {
  const auto found = data_->body_index.find(name);
  return found == data_->body_index.end() ? std::nullopt : std::optional(found->second);
}

std::vector<std::string> Model::velocity_names() const {
  std::vector<std::string> names;
  for (int i = 0; i < bodies(); ++i)
    for (int k = 0; k < link(i).nv; ++k)
      names.push_back(fmt::format("{}.{}", spec().joints[i].name, link(i).kind.traits().v_names[k]));
  return names;
}

std::vector<std::string> Model::position_names() const {
  std::vector<std::string> names;
  for (int i = 0; i < bodies(); ++i)
    for (int k = 0; k < link(i).nq; ++k)
      names.push_back(fmt::format("{}.{}", spec().joints[i].name, link(i).kind.traits().q_names[k]));
  return names;
}

std::vector<std::string> Model::drive_names() const {
  std::vector<std::string> names;
  for (const int body : data_->body_of_drive)
    names.push_back(fmt::format("{}.{}", spec().joints[body].name, link(body).kind.traits().q_names[0]));
  return names;
}

State<double> neutral_state(const Model& model) {
  State<double> state{0, std::vector<double>(model.nq(), 0.0), std::vector<double>(model.nv(), 0.0)};
  for (const Link& link : model.links())
    if (const int w = link.kind.traits().quaternion; w >= 0) state.q[link.q + w] = 1;
  return state;
}

State<double> checked_state(const Model& model, State<double> state) {
  const auto check = [](const std::vector<double>& values, int size, const char* what, const auto& names) {
    if (static_cast<int>(values.size()) != size)
      throw InputError(fmt::format("{} has {} numbers, the model needs {}{}", what, values.size(), size,
                                   size > 12 ? "" : fmt::format(": {}", fmt::join(names(), ", "))));
    for (int k = 0; k < size; ++k)
      if (!std::isfinite(values[k])) throw InputError(fmt::format("{}: {} is not a finite number", what, names()[k]));
  };
  if (!std::isfinite(state.t)) throw InputError("the time is not a finite number");
  check(state.q, model.nq(), "q", [&] { return model.position_names(); });
  check(state.v, model.nv(), "v", [&] { return model.velocity_names(); });
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const int w = link.kind.traits().quaternion;
    if (w < 0) continue;
    double* e = state.q.data() + link.q + w;
    const double norm = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
    if (std::abs(norm - 1) > 1e-6)
      throw InputError(fmt::format("q: the Euler parameters of joint '{}' have length {:.9g}, not 1; normalise them",
                                   model.spec().joints[i].name, norm));
    for (int k = 0; k < 4; ++k) e[k] /= norm;
  }
  return state;
}

}  // namespace lanc
