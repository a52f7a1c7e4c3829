// SPDX-License-Identifier: Apache-2.0
// What a point and a stretch of a ray see of eight clusters of lights (light_tree.h). Included once
// for each kind of lanes.

/// Angles in [0, pi] by their cosines and sines.
struct Angles {
  Lanes cos, sin;
};
inline BRUME_KERNEL Angles anglesOfCosine(const Lanes& cosine) {
  const Lanes one = Lanes::all(1), zero = Lanes::all(0);
  const Lanes c = zero - max(zero - max(cosine, zero - one), zero - one);
  return {c, sqrt(one - c * c)};
}
/// Of sines that rounding may have brought above 1.
inline BRUME_KERNEL Angles anglesOfSine(const Lanes& sine) {
  const Lanes zero = Lanes::all(0), one = Lanes::all(1);
  const Lanes s = zero - max(zero - sine, zero - one);
  return {sqrt(max(one - s * s, zero)), s};
}
/// max(0, a - b)
inline BRUME_KERNEL Angles minus(const Angles& a, const Angles& b) {
  const Lanes isNone = lessEqualMask(b.cos, a.cos);
  return {select(isNone, Lanes::all(1), a.cos * b.cos + a.sin * b.sin),
          select(isNone, Lanes::all(0), a.sin * b.cos - a.cos * b.sin)};
}

/// About the angle of (x, y), y >= 0, to within 0.3 %: whatever it is, it is the same whenever a
/// probability is asked for.
inline BRUME_KERNEL Lanes roughAngle(const Lanes& y, const Lanes& x) {
  const Lanes zero = Lanes::all(0), one = Lanes::all(1);
  const Lanes a = withSign(x, one), large = max(a, y), small = zero - max(zero - a, zero - y);
  const Lanes q = small / max(large, Lanes::all(1e-37f));
  const Lanes low = q * (Lanes::all(0.785398163f) + Lanes::all(0.273f) * (one - q));
  const Lanes angle = select(lessMask(a, y), Lanes::all(1.57079633f) - low, low);
  return select(lessMask(x, zero), Lanes::all(3.14159265f) - angle, angle);
}

/// Part of a cluster's intensity that may leave it at an angle to its axes; 0 when nothing does.
inline BRUME_KERNEL Lanes falloff(const Lanes& cosToAxes, const LightClusters& c) {
  const Lanes cosEmission = Lanes::load(c.cosEmission.data()), one = Lanes::all(1);
  const Lanes inside = select(lessEqualMask(Lanes::all(0), cosEmission),
                              max(cosToAxes, Lanes::all(kLeastFalloff)), one);
  const Lanes part = inside & lessEqualMask(cosEmission, cosToAxes + Lanes::all(kSlack));
  return select(lessMask(Lanes::all(-1), Lanes::load(c.cosAxes.data())), part, one);
}

inline BRUME_KERNEL void seeFromPoint(const PointReceiver::Local& receiver, const LightClusters& c,
                                      ClusterViews& views) {
  const Lanes dx = Lanes::load(c.x.data()) - Lanes::all(receiver.p.x),
              dy = Lanes::load(c.y.data()) - Lanes::all(receiver.p.y),
              dz = Lanes::load(c.z.data()) - Lanes::all(receiver.p.z);
  const Lanes radius = Lanes::load(c.radius.data());
  const Lanes d2 = dx * dx + dy * dy + dz * dz, r2 = radius * radius;
  Lanes importance = Lanes::load(c.intensity.data()) /
                     max(d2 + Lanes::all(kSpread) * r2, Lanes::all(kNearest2));
  views.isOutside = less(r2, d2);
  if (!c.isUniform || receiver.hasNormal) {
    const Lanes one = Lanes::all(1), zero = Lanes::all(0);
    const Lanes inverse = one / sqrt(max(d2, Lanes::all(kNearest2)));
    const Angles ball = anglesOfSine(radius * inverse);
    Lanes factor = one;
    if (!c.isUniform) {
      const Lanes cosine = (Lanes::load(c.axisX.data()) * dx + Lanes::load(c.axisY.data()) * dy +
                            Lanes::load(c.axisZ.data()) * dz) *
                           inverse;
      const Angles axes = {Lanes::load(c.cosAxes.data()), Lanes::load(c.sinAxes.data())};
      factor = falloff(minus(minus(anglesOfCosine(zero - cosine), axes), ball).cos, c);
    }
    if (receiver.hasNormal) {
      const Lanes cosine = (Lanes::all(receiver.n.x) * dx + Lanes::all(receiver.n.y) * dy +
                            Lanes::all(receiver.n.z) * dz) *
                           inverse;
      const Angles toNormal = minus(anglesOfCosine(withSign(cosine, one)), ball);
      factor = factor * max(toNormal.cos, Lanes::all(kSlack));
    }
    importance = importance * select(lessMask(r2, d2), factor, one);
  }
  importance.store(views.importance.data());
}

inline BRUME_KERNEL void seeFromRay(const RayReceiver::Local& receiver, const LightClusters& c,
                                    ClusterViews& views) {
  const Lanes zero = Lanes::all(0), one = Lanes::all(1), nearest2 = Lanes::all(kNearest2);
  const Lanes dx = Lanes::all(receiver.d.x), dy = Lanes::all(receiver.d.y),
              dz = Lanes::all(receiver.d.z);
  const Lanes cx = Lanes::load(c.x.data()) - Lanes::all(receiver.o.x),
              cy = Lanes::load(c.y.data()) - Lanes::all(receiver.o.y),
              cz = Lanes::load(c.z.data()) - Lanes::all(receiver.o.z);
  // From the foot of the centre on the line: the stretch reaches from a to b, the centre lies
  // aside.
  const Lanes foot = cx * dx + cy * dy + cz * dz;
  const Lanes a = Lanes::all(receiver.t0) - foot, b = Lanes::all(receiver.t1) - foot;
  const Lanes ax = cx - dx * foot, ay = cy - dy * foot, az = cz - dz * foot;
  const Lanes radius = Lanes::load(c.radius.data());
  const Lanes aside2 = ax * ax + ay * ay + az * az, r2 = radius * radius;
  const Lanes reach = Lanes::all(1e-6f) * max(withSign(a, one), withSign(b, one));
  const Lanes D2 = max(max(aside2 + Lanes::all(kSpread) * r2, reach * reach), nearest2);
  const Lanes D = sqrt(D2);
  Lanes importance =
      Lanes::load(c.intensity.data()) * roughAngle(D * (b - a), D2 + a * b) / D;
  const Lanes along = max(max(a, zero - b), zero), d2 = aside2 + along * along;
  views.isOutside = less(r2, d2);
  if (!c.isUniform) {
    // The directions from the centre to the stretch fill an arc; from the ball, a cone around it.
    const Lanes toA = one / sqrt(max(aside2 + a * a, nearest2)),
                toB = one / sqrt(max(aside2 + b * b, nearest2));
    const Lanes forward = a * toA + b * toB, sideways = toA + toB;
    const Lanes sx = dx * forward - ax * sideways, sy = dy * forward - ay * sideways,
                sz = dz * forward - az * sideways;
    const Lanes l = sqrt(sx * sx + sy * sy + sz * sz), least = Lanes::all(1e-3f);
    const Lanes cosine = (Lanes::load(c.axisX.data()) * sx + Lanes::load(c.axisY.data()) * sy +
                          Lanes::load(c.axisZ.data()) * sz) /
                         max(l, least);
    const Angles axes = {Lanes::load(c.cosAxes.data()), Lanes::load(c.sinAxes.data())};
    const Angles toArc =
        minus(minus(anglesOfCosine(cosine), axes), anglesOfCosine(Lanes::all(0.5f) * l));
    const Angles ball = anglesOfSine(radius / sqrt(max(d2, nearest2)));
    const Lanes isKnown = lessMask(r2, d2) & lessMask(least, l);
    importance = importance * select(isKnown, falloff(minus(toArc, ball).cos, c), one);
  }
  importance.store(views.importance.data());
}
