//! The scripts of `synthetic-d2`.

use super::super::actor::Kind;
use super::super::ground::Ground;
use super::{CAR, HEAD, ROOF, S, Script, along, crosses, stands, thing, vehicle};

/// The sequences, in the order of their names.
#[rustfmt::skip]
pub const SCRIPTS: &[Script] = &[
    // Through an arcade.
    Script { name: "car-arcade", look: 4,
        path: &[(0.0, 44.0, 178.0), (70.0, 130.0, 176.0), (150.0, 286.0, 178.0)],
        others: &[thing(Kind::Wall, 7, (168.0, 168.0), (100.0, 84.0))],
        ..CAR },
    // Twigs hide parts of it.
    Script { name: "car-avenue", look: 11,
        path: &[(0.0, 30.0, 98.0), (70.0, 150.0, 100.0), (140.0, 288.0, 98.0)],
        others: &[
            thing(Kind::Bush, 4, (110.0, 84.0), (34.0, 36.0)), thing(Kind::Bush, 9, (200.0, 106.0), (66.0, 60.0)),
        ],
        ..ROOF },
    // Under a footbridge.
    Script { name: "car-bridge-narrow", look: 5,
        path: &[(0.0, 36.0, 136.0), (60.0, 140.0, 136.0), (130.0, 288.0, 136.0)],
        others: &[thing(Kind::Wall, 4, (160.0, 120.0), (54.0, 250.0))],
        ..ROOF },
    // Under a motorway.
    Script { name: "car-bridge-wide", look: 13,
        path: &[(0.0, 290.0, 104.0), (60.0, 210.0, 104.0), (150.0, 36.0, 102.0)],
        mirrored: true,
        others: &[thing(Kind::Wall, 2, (150.0, 120.0), (104.0, 250.0))],
        ..ROOF },
    // Lights go out along the street.
    Script { name: "car-dusk", look: 6,
        path: &[(0.0, 50.0, 180.0), (80.0, 160.0, 178.0), (150.0, 270.0, 180.0)],
        light: &[(0.0, 1.0), (50.0, 1.0), (100.0, 0.25), (150.0, 0.22)],
        ..CAR },
    // Waits below a roof.
    Script { name: "car-gate", look: 2,
        path: &[(0.0, 34.0, 166.0), (70.0, 150.0, 166.0), (100.0, 160.0, 166.0), (170.0, 284.0, 166.0)],
        others: &[thing(Kind::Wall, 9, (158.0, 170.0), (76.0, 70.0))],
        ..ROOF },
    // Drives off.
    Script { name: "car-hill", kind: Kind::Rear, look: 5, size: (54.0, 46.0),
        path: &[(0.0, 110.0, 190.0), (90.0, 160.0, 176.0), (170.0, 200.0, 166.0)],
        scale: &[(0.0, 1.0), (170.0, 0.5)],
        ..S },
    // Past a lamp post and behind a wall.
    Script { name: "car-left", look: 9, mirrored: true,
        path: &[(0.0, 284.0, 180.0), (60.0, 160.0, 178.0), (120.0, 40.0, 180.0)],
        others: &[thing(Kind::Post, 6, (204.0, 110.0), (12.0, 240.0)), thing(Kind::Wall, 8, (136.0, 172.0), (88.0, 70.0))],
        ..CAR },
    // A lorry passes above it.
    Script { name: "car-lorry", look: 8,
        path: &[(0.0, 40.0, 134.0), (70.0, 140.0, 136.0), (140.0, 280.0, 134.0)],
        others: &[vehicle(Kind::Wall, 3, 70.0, (-3.4, 0.0), (120.0, 40.0))],
        ..ROOF },
    // Others in the opposite lane, close by, and a lorry.
    Script { name: "car-oncoming", look: 10,
        path: &[(0.0, 34.0, 128.0), (75.0, 150.0, 128.0), (150.0, 286.0, 128.0)],
        others: &[
            crosses(4, 60.0, (-2.6, 0.15)).mirrored(), crosses(6, 100.0, (-3.0, -0.1)).mirrored(),
            vehicle(Kind::Wall, 8, 112.0, (-2.8, 0.0), (140.0, 44.0)),
        ],
        ..ROOF },
    // Turns on a square, below a tree.
    Script { name: "car-park", ground: Ground::Plaza, look: 16,
        path: &[(0.0, 50.0, 60.0), (50.0, 150.0, 62.0), (80.0, 186.0, 90.0), (160.0, 190.0, 206.0)],
        turn: &[(0.0, 0.0), (50.0, 4.0), (80.0, 74.0), (110.0, 90.0)],
        others: &[thing(Kind::Bush, 8, (190.0, 150.0), (70.0, 66.0))],
        ..ROOF },
    // Overtaken by one of its make.
    Script { name: "car-pass", look: 12,
        path: &[(0.0, 60.0, 100.0), (75.0, 160.0, 100.0), (150.0, 196.0, 100.0)],
        others: &[crosses(12, 90.0, (2.6, 0.1)), stands(15, 270.0, 136.0).behind()],
        ..ROOF },
    // Catches up with the camera.
    Script { name: "car-rear", kind: Kind::Rear, look: 7, size: (56.0, 48.0),
        path: &[(0.0, 200.0, 164.0), (70.0, 170.0, 172.0), (150.0, 130.0, 188.0)],
        scale: &[(0.0, 0.6), (150.0, 1.1)],
        others: &[thing(Kind::Rear, 2, (268.0, 180.0), (50.0, 42.0)).behind()],
        ..S },
    // Stops in a shed and leaves it.
    Script { name: "car-shed", look: 10,
        path: &[(0.0, 44.0, 182.0), (70.0, 164.0, 180.0), (100.0, 170.0, 180.0), (170.0, 286.0, 182.0)],
        others: &[thing(Kind::Wall, 8, (168.0, 172.0), (92.0, 76.0))],
        ..CAR },
    // Through the shade of a house.
    Script { name: "car-sun", look: 14,
        path: &[(0.0, 30.0, 168.0), (70.0, 150.0, 168.0), (140.0, 290.0, 168.0)],
        shadow: (&[(0.0, 160.0)], 90.0),
        ..ROOF },
    // Into a tunnel in which it stays.
    Script { name: "car-tunnel", look: 3,
        path: &[(0.0, 36.0, 104.0), (90.0, 220.0, 104.0), (150.0, 262.0, 104.0)],
        others: &[thing(Kind::Wall, 6, (252.0, 120.0), (130.0, 250.0))],
        ..ROOF },
    // A card is held up before it and taken away.
    Script { name: "face-card", look: 5,
        path: &[(0.0, 140.0, 104.0), (70.0, 160.0, 100.0), (150.0, 190.0, 108.0)],
        pose: &[(0.0, 0.0), (150.0, 0.06)],
        others: &[vehicle(Kind::Card, 5, 84.0, (0.4, -1.5), (84.0, 110.0))],
        ..HEAD },
    // Looks left and right.
    Script { name: "face-counter", look: 21,
        path: &[(0.0, 150.0, 100.0), (80.0, 176.0, 104.0), (160.0, 150.0, 100.0)],
        pose: &[(0.0, 0.0), (40.0, 0.16), (90.0, -0.16), (130.0, 0.1), (160.0, 0.0)],
        ..HEAD },
    // Two others pass.
    Script { name: "face-crowd", ground: Ground::Hall, look: 30, size: (30.0, 38.0),
        path: &[(0.0, 80.0, 96.0), (75.0, 150.0, 100.0), (150.0, 250.0, 96.0)],
        others: &[crosses(33, 70.0, (-1.6, 0.0)).scaled(1.2), crosses(36, 110.0, (-2.4, 0.1)).scaled(1.1)],
        ..HEAD },
    // The light fails.
    Script { name: "face-dark", look: 8,
        path: &[(0.0, 120.0, 100.0), (70.0, 170.0, 96.0), (140.0, 230.0, 104.0)],
        light: &[(0.0, 1.0), (50.0, 1.0), (62.0, 0.3), (140.0, 0.28)],
        ..HEAD },
    // Goes behind a partition.
    Script { name: "face-door", look: 12,
        path: &[(0.0, 70.0, 104.0), (70.0, 150.0, 100.0), (150.0, 262.0, 104.0)],
        others: &[thing(Kind::Wall, 5, (168.0, 130.0), (84.0, 230.0))],
        ..HEAD },
    // Comes near.
    Script { name: "face-near", look: 26, size: (28.0, 36.0),
        path: &[(0.0, 120.0, 90.0), (70.0, 150.0, 98.0), (130.0, 190.0, 112.0)],
        scale: &[(0.0, 1.0), (130.0, 1.8)],
        ..HEAD },
    // Sways and turns.
    Script { name: "face-nod", look: 31,
        path: &[(0.0, 150.0, 100.0), (30.0, 162.0, 96.0), (60.0, 140.0, 112.0), (90.0, 170.0, 98.0), (130.0, 150.0, 104.0)],
        pose: &[(0.0, 0.05), (60.0, 0.22), (130.0, -0.05)],
        ..HEAD },
    // Behind a pillar of a hall.
    Script { name: "face-pillar", ground: Ground::Hall, look: 19, size: (30.0, 38.0),
        path: &[(0.0, 70.0, 100.0), (75.0, 160.0, 102.0), (150.0, 300.0, 100.0)],
        others: &[thing(Kind::Wall, 2, (186.0, 140.0), (62.0, 300.0))],
        ..HEAD },
    // Behind a post.
    Script { name: "face-post", look: 41,
        path: &[(0.0, 90.0, 104.0), (70.0, 150.0, 100.0), (140.0, 240.0, 104.0)],
        others: &[thing(Kind::Post, 4, (166.0, 120.0), (60.0, 240.0))],
        ..HEAD },
    // Stays behind a screen.
    Script { name: "face-screen", look: 44,
        path: &[(0.0, 90.0, 106.0), (70.0, 180.0, 100.0), (110.0, 190.0, 100.0), (160.0, 250.0, 106.0)],
        others: &[thing(Kind::Wall, 9, (188.0, 120.0), (70.0, 110.0))],
        ..HEAD },
    // Turns away and goes behind a partition.
    Script { name: "face-turn", look: 50,
        path: &[(0.0, 110.0, 104.0), (60.0, 140.0, 100.0), (150.0, 250.0, 104.0)],
        pose: &[(0.0, 0.0), (40.0, 0.0), (80.0, 0.5), (150.0, 0.55)],
        others: &[thing(Kind::Wall, 7, (196.0, 130.0), (72.0, 230.0))],
        ..HEAD },
    // Another complexion passes before it.
    Script { name: "face-two", look: 54,
        path: &[(0.0, 120.0, 104.0), (75.0, 160.0, 100.0), (150.0, 200.0, 104.0)],
        others: &[crosses(57, 75.0, (-0.9, 0.0)).scaled(2.0)],
        ..HEAD },
    // Past a window.
    Script { name: "face-window", look: 60,
        path: &[(0.0, 80.0, 104.0), (65.0, 150.0, 100.0), (130.0, 240.0, 104.0)],
        shadow: (&[(0.0, 180.0)], 70.0),
        ..HEAD },
    // Behind the end of a wall.
    Script { name: "person-alley", ground: Ground::Bricks, look: 12,
        path: &[(0.0, 40.0, 166.0), (70.0, 130.0, 166.0), (150.0, 280.0, 166.0)],
        others: &[thing(Kind::Wall, 7, (170.0, 160.0), (80.0, 110.0))],
        ..S },
    // Legs behind a bench.
    Script { name: "person-bench", ground: Ground::Meadow, look: 18,
        path: &[(0.0, 50.0, 140.0), (75.0, 140.0, 142.0), (150.0, 260.0, 140.0)],
        others: &[thing(Kind::Hoarding, 3, (150.0, 172.0), (70.0, 34.0))],
        ..S },
    // A bus stops before somebody and drives on.
    Script { name: "person-bus", look: 26,
        path: &[(0.0, 60.0, 138.0), (60.0, 130.0, 140.0), (150.0, 250.0, 138.0)],
        others: &[vehicle(Kind::Hoarding, 2, 96.0, (3.4, 0.0), (150.0, 96.0))],
        ..S },
    // Behind a hedge.
    Script { name: "person-bushes", ground: Ground::Meadow, look: 23,
        path: &[(0.0, 284.0, 144.0), (70.0, 190.0, 144.0), (150.0, 40.0, 144.0)],
        others: &[thing(Kind::Bush, 6, (150.0, 150.0), (110.0, 112.0))],
        ..S },
    // Two of different clothes, behind a tree.
    Script { name: "person-couple", ground: Ground::Plaza, look: 29,
        path: &[(0.0, 60.0, 90.0), (75.0, 150.0, 120.0), (150.0, 250.0, 150.0)],
        others: &[along(36, &[(0.0, 30.0)], &[(0.0, -8.0)]).behind(), thing(Kind::Bush, 4, (156.0, 120.0), (84.0, 104.0))],
        ..S },
    // Another one comes the other way.
    Script { name: "person-cross", ground: Ground::Plaza, look: 38,
        path: &[(0.0, 50.0, 120.0), (70.0, 150.0, 122.0), (140.0, 260.0, 120.0)],
        others: &[crosses(43, 70.0, (-1.6, 0.0))],
        ..S },
    // Evening.
    Script { name: "person-dim", look: 47,
        path: &[(0.0, 60.0, 140.0), (75.0, 150.0, 142.0), (150.0, 240.0, 140.0)],
        light: &[(0.0, 1.0), (50.0, 1.0), (90.0, 0.25), (150.0, 0.22)],
        ..S },
    // Walks away over the hall, behind a pillar.
    Script { name: "person-far", ground: Ground::Hall, look: 51, size: (32.0, 90.0),
        path: &[(0.0, 100.0, 190.0), (75.0, 160.0, 164.0), (150.0, 210.0, 140.0)],
        scale: &[(0.0, 1.0), (150.0, 0.6)],
        others: &[thing(Kind::Wall, 3, (176.0, 150.0), (58.0, 200.0))],
        ..S },
    // Behind the pillar of a hall.
    Script { name: "person-hall", ground: Ground::Hall, look: 55, size: (28.0, 78.0),
        path: &[(0.0, 50.0, 156.0), (75.0, 150.0, 158.0), (150.0, 310.0, 156.0)],
        others: &[thing(Kind::Wall, 6, (184.0, 130.0), (66.0, 270.0))],
        ..S },
    // Waits behind a kiosk.
    Script { name: "person-kiosk", look: 59,
        path: &[(0.0, 40.0, 142.0), (70.0, 150.0, 142.0), (100.0, 156.0, 142.0), (160.0, 270.0, 142.0)],
        others: &[thing(Kind::Wall, 1, (152.0, 138.0), (70.0, 96.0))],
        ..S },
    // Past a lamp post and behind a shelter.
    Script { name: "person-lamp", look: 63,
        path: &[(0.0, 40.0, 140.0), (70.0, 150.0, 140.0), (140.0, 280.0, 140.0)],
        others: &[thing(Kind::Post, 3, (110.0, 120.0), (10.0, 230.0)), thing(Kind::Wall, 11, (206.0, 138.0), (72.0, 92.0))],
        ..S },
    // A lorry drives by.
    Script { name: "person-lorry", look: 68,
        path: &[(0.0, 80.0, 140.0), (75.0, 150.0, 140.0), (150.0, 220.0, 140.0)],
        others: &[vehicle(Kind::Hoarding, 12, 80.0, (-3.6, 0.0), (120.0, 98.0))],
        ..S },
    // Comes nearer, past a bush.
    Script { name: "person-near", ground: Ground::Plaza, look: 72, size: (22.0, 62.0),
        path: &[(0.0, 90.0, 80.0), (65.0, 150.0, 100.0), (130.0, 200.0, 132.0)],
        scale: &[(0.0, 1.0), (130.0, 1.6)],
        others: &[thing(Kind::Bush, 7, (150.0, 104.0), (74.0, 100.0))],
        ..S },
    // Behind two trunks.
    Script { name: "person-palings", ground: Ground::Meadow, look: 76,
        path: &[(0.0, 50.0, 142.0), (75.0, 150.0, 142.0), (150.0, 270.0, 142.0)],
        others: &[thing(Kind::Post, 5, (120.0, 110.0), (18.0, 190.0)), thing(Kind::Post, 9, (204.0, 110.0), (64.0, 190.0))],
        ..S },
    // Into a passage and out of it.
    Script { name: "person-passage", ground: Ground::Bricks, look: 79,
        path: &[(0.0, 280.0, 166.0), (70.0, 190.0, 166.0), (150.0, 50.0, 166.0)],
        others: &[thing(Kind::Wall, 3, (150.0, 160.0), (86.0, 120.0))],
        ..S },
    // Among others, one in the same clothes.
    Script { name: "person-queue", ground: Ground::Hall, look: 84, size: (28.0, 78.0),
        path: &[(0.0, 80.0, 160.0), (75.0, 140.0, 160.0), (150.0, 220.0, 162.0)],
        others: &[along(88, &[(0.0, 34.0)], &[(0.0, -3.0)]).behind(), along(84, &[(0.0, -40.0), (60.0, -34.0), (95.0, 2.0), (120.0, 10.0), (150.0, 60.0)], &[(0.0, 5.0)])],
        ..S },
    // Through the shade.
    Script { name: "person-shade", ground: Ground::Plaza, look: 87,
        path: &[(0.0, 40.0, 120.0), (70.0, 150.0, 120.0), (140.0, 280.0, 120.0)],
        shadow: (&[(0.0, 160.0)], 80.0),
        ..S },
    // Into a shop for good.
    Script { name: "person-shop", ground: Ground::Hall, look: 93, size: (28.0, 78.0),
        path: &[(0.0, 70.0, 160.0), (90.0, 220.0, 150.0), (160.0, 270.0, 148.0)],
        others: &[thing(Kind::Wall, 8, (262.0, 130.0), (92.0, 180.0))],
        ..S },
    // Down, behind a balustrade.
    Script { name: "person-stairs", ground: Ground::Hall, look: 97, size: (28.0, 78.0),
        path: &[(0.0, 80.0, 140.0), (75.0, 150.0, 160.0), (150.0, 250.0, 190.0)],
        scale: &[(0.0, 0.9), (150.0, 1.15)],
        others: &[thing(Kind::Wall, 4, (200.0, 190.0), (90.0, 140.0))],
        ..S },
    // A tram hides somebody who walks along with it.
    Script { name: "person-tram", look: 103,
        path: &[(0.0, 50.0, 138.0), (75.0, 140.0, 140.0), (150.0, 270.0, 138.0)],
        others: &[vehicle(Kind::Hoarding, 6, 100.0, (3.2, 0.0), (170.0, 96.0))],
        ..S },
    // Two others of other colors cross.
    Script { name: "person-trio", ground: Ground::Plaza, look: 106,
        path: &[(0.0, 60.0, 110.0), (75.0, 150.0, 124.0), (150.0, 250.0, 112.0)],
        others: &[crosses(110, 60.0, (-1.4, 0.5)), crosses(106, 90.0, (-1.0, -0.8))],
        ..S },
    // Along the back of a long wall.
    Script { name: "person-wall", ground: Ground::Street, look: 109,
        path: &[(0.0, 36.0, 142.0), (80.0, 140.0, 142.0), (160.0, 284.0, 142.0)],
        others: &[thing(Kind::Wall, 10, (176.0, 140.0), (110.0, 92.0))],
        ..S },
];
