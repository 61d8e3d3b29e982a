// Simbody behind plain numbers: its headers do not compile as C++20, ours do not compile as C++17. Private to the peer
// in simbody.cpp.
#pragma once

#include <array>
#include <memory>
#include <string>

namespace lanc::peers {

using Numbers3 = std::array<double, 3>;
using Numbers9 = std::array<double, 9>;  // a rotation, column by column

struct SimbodyFrame {
  Numbers9 axes;
  Numbers3 origin;
};

struct SimbodyMass {
  double mass;
  Numbers3 com;
  std::array<double, 6> inertia;  // about the origin of the body: xx, yy, zz, xy, xz, yz
};

/// A multibody system and one state of it. Bodies are numbered from 0 in the order in which they are added; −1 is
/// ground. Joint axes are z; twists of free and spherical joints in axes of the joint's frame on the predecessor.
class SimbodyTree {
 public:
  enum class Joint { revolute, prismatic, spherical, free, fixed };

  explicit SimbodyTree(const Numbers3& gravity);
  ~SimbodyTree();

  void add_body(int parent, Joint joint, const SimbodyFrame& on_parent, const SimbodyMass& mass);
  void add_ball(int a, const Numbers3& point_a, int b, const Numbers3& point_b);
  void add_weld(int a, const SimbodyFrame& frame_a, int b, const SimbodyFrame& frame_b);
  /// To be called once, when all is added and before anything below.
  void finish();

  void set_coordinate(int body, double q, double v);
  void set_rotation(int body, const Numbers9& rotation, const Numbers3& angular);
  void set_translation(int body, const Numbers3& position, const Numbers3& linear);

  /// Sets all positions and velocities anew and realises accelerations.
  void accelerate();
  double acceleration(int body, int coordinate) const;

  static std::string version();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lanc::peers
