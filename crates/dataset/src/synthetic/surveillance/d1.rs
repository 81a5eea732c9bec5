//! The scripts of `synthetic-d1`.

use super::super::actor::Kind;
use super::super::ground::Ground;
use super::{CAR, HEAD, ROOF, S, Script, along, crosses, stands, thing, vehicle};

/// The sequences, in the order of their names.
#[rustfmt::skip]
pub const SCRIPTS: &[Script] = &[
    // A car from behind that drives off, past a lorry.
    Script { name: "car-away", kind: Kind::Rear, look: 2, size: (56.0, 47.0),
        path: &[(0.0, 150.0, 188.0), (90.0, 178.0, 172.0), (140.0, 214.0, 164.0), (210.0, 176.0, 158.0)],
        scale: &[(0.0, 1.0), (100.0, 0.75), (210.0, 0.55)],
        others: &[
            thing(Kind::Rear, 9, (60.0, 186.0), (60.0, 50.0)).behind(),
            vehicle(Kind::Hoarding, 4, 124.0, (-1.5, 0.0), (110.0, 70.0)),
        ],
        ..S },
    // Under a bridge.
    Script { name: "car-bridge", look: 1,
        path: &[(0.0, 32.0, 102.0), (40.0, 74.0, 102.0), (170.0, 290.0, 104.0)],
        others: &[
            crosses(6, 60.0, (-2.4, 0.2)).mirrored().behind(),
            thing(Kind::Wall, 3, (176.0, 120.0), (86.0, 250.0)),
        ],
        ..ROOF },
    // In a queue of cars of its make, which other lanes pass.
    Script { name: "car-queue", look: 7,
        path: &[(0.0, 60.0, 138.0), (50.0, 140.0, 138.0), (110.0, 170.0, 138.0), (160.0, 176.0, 136.0), (230.0, 272.0, 132.0)],
        others: &[
            stands(7, 246.0, 166.0).behind(), stands(12, 196.0, 166.0).behind(),
            along(7, &[(0.0, 58.0), (100.0, 54.0), (170.0, 56.0), (230.0, 120.0)], &[(0.0, 1.0)]).behind(),
            crosses(7, 86.0, (-3.0, 0.3)).mirrored(),
            crosses(5, 150.0, (-2.6, -0.6)).mirrored(),
        ],
        ..ROOF },
    // Past lorries on a street with sun and shade.
    Script { name: "car-shade", look: 3,
        path: &[(0.0, 44.0, 178.0), (90.0, 176.0, 176.0), (190.0, 288.0, 182.0)],
        others: &[
            thing(Kind::Car, 3, (250.0, 158.0), (58.0, 28.0)).behind(),
            thing(Kind::Hoarding, 8, (150.0, 186.0), (58.0, 60.0)),
        ],
        shadow: (&[(0.0, 230.0), (190.0, 214.0)], 110.0),
        light: &[(0.0, 1.0), (90.0, 1.0), (130.0, 0.8), (190.0, 0.9)],
        ..CAR },
    // Below the crowns of trees.
    Script { name: "car-trees", look: 9,
        path: &[(0.0, 290.0, 168.0), (60.0, 220.0, 168.0), (120.0, 130.0, 166.0), (200.0, 40.0, 168.0)],
        mirrored: true,
        others: &[
            crosses(14, 100.0, (2.2, 0.0)).behind(),
            thing(Kind::Bush, 3, (196.0, 172.0), (48.0, 44.0)),
            thing(Kind::Bush, 5, (112.0, 170.0), (84.0, 80.0)),
        ],
        ..ROOF },
    // Somebody passes before a face of the same complexion.
    Script { name: "face-cross", look: 3,
        path: &[(0.0, 110.0, 110.0), (70.0, 160.0, 106.0), (170.0, 210.0, 112.0)],
        pose: &[(0.0, 0.0), (60.0, 0.06), (120.0, -0.08), (170.0, 0.02)],
        others: &[crosses(3, 84.0, (-2.2, 0.0)).scaled(1.25)],
        ..HEAD },
    // At a desk under a lamp that goes off and on.
    Script { name: "face-lamp", look: 14,
        path: &[(0.0, 130.0, 100.0), (50.0, 160.0, 94.0), (110.0, 210.0, 110.0), (180.0, 150.0, 100.0)],
        pose: &[(0.0, 0.0), (50.0, 0.05), (90.0, 0.2), (130.0, 0.0), (160.0, -0.2), (180.0, -0.1)],
        scale: &[(0.0, 1.0), (90.0, 1.15), (180.0, 0.95)],
        light: &[(0.0, 1.0), (40.0, 1.0), (46.0, 0.4), (96.0, 0.36), (102.0, 1.2), (130.0, 1.0)],
        others: &[thing(Kind::Card, 5, (232.0, 150.0), (60.0, 78.0))],
        ..HEAD },
    // Two who change places.
    Script { name: "face-pair", look: 10,
        path: &[(0.0, 100.0, 104.0), (60.0, 120.0, 100.0), (110.0, 220.0, 112.0), (190.0, 240.0, 104.0)],
        pose: &[(0.0, 0.0), (70.0, 0.1), (100.0, 0.2), (130.0, 0.05), (190.0, 0.0)],
        others: &[along(10, &[(0.0, 120.0), (50.0, 100.0), (80.0, 10.0), (120.0, -110.0), (190.0, -120.0)],
            &[(0.0, 4.0)])],
        ..HEAD },
    // A head that turns away and back.
    Script { name: "face-turn", look: 6,
        path: &[(0.0, 150.0, 104.0), (60.0, 190.0, 100.0), (120.0, 250.0, 110.0), (170.0, 180.0, 104.0), (200.0, 150.0, 100.0)],
        pose: &[(0.0, 0.0), (40.0, 0.0), (66.0, 0.5), (130.0, 0.6), (170.0, 1.0), (200.0, 1.0)],
        others: &[stands(6, 128.0, 112.0).behind()],
        ..HEAD },
    // Towards the camera, past another.
    Script { name: "face-walk", ground: Ground::Hall, look: 17, size: (26.0, 33.0),
        path: &[(0.0, 70.0, 90.0), (60.0, 130.0, 96.0), (110.0, 220.0, 104.0), (150.0, 260.0, 112.0)],
        scale: &[(0.0, 1.0), (150.0, 1.6)],
        pose: &[(0.0, 0.04), (70.0, 0.1), (150.0, -0.05)],
        others: &[stands(9, 180.0, 110.0).scaled(1.5)],
        ..HEAD },
    // A crossing with many who look alike.
    Script { name: "person-crossing", ground: Ground::Plaza, look: 15,
        path: &[(0.0, 40.0, 120.0), (80.0, 130.0, 126.0), (160.0, 190.0, 130.0), (260.0, 280.0, 124.0)],
        others: &[
            crosses(15, 150.0, (-1.2, -0.3)).behind(), stands(21, 90.0, 90.0).behind(),
            crosses(23, 60.0, (-1.7, 0.4)), crosses(15, 110.0, (-1.6, 0.2)), crosses(26, 190.0, (-1.5, -0.5)),
        ],
        ..S },
    // In a group that parts.
    Script { name: "person-group", ground: Ground::Hall, look: 31, size: (28.0, 78.0),
        path: &[(0.0, 60.0, 160.0), (100.0, 150.0, 164.0), (210.0, 270.0, 168.0)],
        others: &[
            along(34, &[(0.0, -30.0), (100.0, -26.0), (150.0, -80.0), (210.0, -160.0)], &[(0.0, -6.0)]).behind(),
            along(31, &[(0.0, 32.0), (70.0, 26.0), (110.0, 4.0), (150.0, -20.0), (210.0, -100.0)],
                &[(0.0, 6.0), (150.0, 8.0), (210.0, 20.0)]),
        ],
        ..S },
    // Through a hall, away from the camera.
    Script { name: "person-hall", ground: Ground::Hall, look: 44, size: (30.0, 84.0),
        path: &[(0.0, 70.0, 184.0), (80.0, 140.0, 160.0), (180.0, 230.0, 132.0)],
        scale: &[(0.0, 1.0), (180.0, 0.65)],
        others: &[crosses(41, 90.0, (-1.6, 0.5)), thing(Kind::Wall, 4, (196.0, 150.0), (52.0, 130.0))],
        ..S },
    // Behind a kiosk.
    Script { name: "person-kiosk", look: 52,
        path: &[(0.0, 36.0, 142.0), (100.0, 140.0, 142.0), (200.0, 284.0, 144.0)],
        others: &[
            crosses(58, 40.0, (-1.2, 0.0)).behind(),
            thing(Kind::Wall, 6, (170.0, 140.0), (74.0, 92.0)),
        ],
        ..S },
    // A lorry drives by.
    Script { name: "person-lorry", look: 66,
        path: &[(0.0, 60.0, 138.0), (90.0, 150.0, 140.0), (200.0, 240.0, 138.0)],
        others: &[
            stands(66, 104.0, 132.0).behind(),
            vehicle(Kind::Hoarding, 8, 100.0, (-3.2, 0.0), (170.0, 96.0)),
        ],
        ..S },
    // Trunks and bushes of a park.
    Script { name: "person-park", ground: Ground::Meadow, look: 71,
        path: &[(0.0, 270.0, 142.0), (90.0, 180.0, 146.0), (160.0, 100.0, 142.0), (230.0, 40.0, 146.0)],
        others: &[
            crosses(71, 120.0, (1.3, 0.1)),
            thing(Kind::Post, 3, (206.0, 110.0), (26.0, 190.0)),
            thing(Kind::Bush, 5, (104.0, 160.0), (72.0, 92.0)),
        ],
        shadow: (&[(0.0, 150.0)], 60.0),
        ..S },
    // Pillars.
    Script { name: "person-pillars", ground: Ground::Hall, look: 83, size: (26.0, 74.0),
        path: &[(0.0, 50.0, 150.0), (80.0, 150.0, 152.0), (140.0, 210.0, 150.0), (210.0, 310.0, 154.0)],
        others: &[
            crosses(83, 130.0, (-1.4, 0.2)).behind(),
            thing(Kind::Wall, 2, (112.0, 120.0), (34.0, 240.0)),
            thing(Kind::Wall, 2, (222.0, 120.0), (40.0, 240.0)),
        ],
        ..S },
    // Behind a wall and out again on the same side.
    Script { name: "person-return", ground: Ground::Bricks, look: 90,
        path: &[(0.0, 60.0, 164.0), (90.0, 200.0, 164.0), (130.0, 210.0, 164.0), (250.0, 70.0, 166.0)],
        others: &[
            stands(95, 110.0, 158.0).behind(),
            thing(Kind::Wall, 5, (206.0, 160.0), (84.0, 96.0)),
        ],
        ..S },
];
