//! Small bags written by other software: the Python packages mcap and mcap-ros2-support, rosbags,
//! and SQLite itself. Each is gzipped, in base64; the names say the compression within.

use super::database::{DB3, WAL_DB3, WAL_LOG, bytes};
use super::{Read, all};
use loc_ros::{Bag1, Database3, Decoder, Encoding, McapReader};
use std::io::Cursor;
use std::path::Path;

/// 2279 bytes.
const MCAP_ZSTD: &str = "H4sIAAAAAAACA7WWfUwTdxjHr9df2+PaUloRlSE7sLx0Ci2FMeJSV8deJAsLG06XLRme7YHN+ubdkVj/0BIJambAaEi2qGAWTcgy/2HZP8bFJfMPE5coxuzNSeY2iVBeWl4LpbBr7zkoHf6zzF/Sfn+f53l+1+d6T5+np+trdzdYtKTsZUxcSHixPs5qEtTjoP1l/gB/yOc1V5RXl1uopCXhLuNa/X4fy5stCbuyFRdPP5WLqkOiDmlF/Y7bP5gwHeV4Zx3Eln5rjh8Y0sT1mDFHLscxGZYvWFsYn4fh2UCTh2vhzMKbucHn8vKNPO3xM04VZCfY78kwTLjaHoZ2Mix1iKT8pI2sb3x7J0UebHW5eZe3STjHsM20g+HMe10ehuJIjmdd3haqmaU9TJPLSQoRlVaKYxxkq5f2+shmt4/mq6uoI4GjJNoipKQUPtDsT9yVw8kqXn8qmDAVfE0e2o+Fb2Lh48PDsj9eGxnBw6GQPDo6ijD72JgCjY8riYkJlSYcJrIikQzD5CSZPTWlzpme1myemdHmzs5m5s3N6fKj0Sxqfl5fsLBgKIzFNmxbXMw2xuMbi5aWcoqXlzeVbC61y9AWkx1HuS/Z5eiF7XaE8nYo0NYyJcovV6EXzQSiLBmoIGghUWGFGm0LVmiQ0apFRUFrJiqu1KGSYGXwdt/A16ZzVyhTPRc8Yazbabhs//CNvgJ7Ft5+ytlGFPXcjx2md33S/sP31TfktEdTNHjrjFVb+nf0cUfoTYvG/bHtSgNyfNqH6i1n3BvN43ce3jGEHn/j77ZVqUu21nbf9gzs5b8a0/Xq7/f/9PvJ3u3nexz72GtPdF167vDPD052XWh85HifvTrTpez9rD235reaS6/wmY+OH/my6vM8Q/zEhrbsWM+SUkHZbGezfI3T/X8O5T8sKznV/OSuC/1lP7bj+tnZd4z7tMYHle/F7u3q7CAKvnBHum9clKk6oKJkWBBfrcFysA4DB4BHgG8Bh6SaBR0F/Qh0DPQq6DhoGHQC9FW01t4BHAEeAJ4EzlOIOgXcAjwN3A88AxwHngXeoxR1Dvg8cBR4EHge2KQSdQGYB44B3wReBCYJ+FzgD4CXgC8DLwOHiJQWIqzqDHgqwG3AOPCPwHLgTSQcBz4IrAC+BqwEjgKrgGvVohLAncAZwL8Ck8BGjahqYB+wBvg6sBZYAb0sE7hBu7bXXUhj8ebkK7X5X7qbGCf1uKSQa6+RPJ/off/zEltpWgrP7qyJG/hXd30+OT0jh9ReLm4THT2BzyeNdR7D6vhY2QVWdsmBItWCNFgSp2C4JEuxBiJKUyJXl2ydCUsm7VI88S62/iB+C+zH8NRjUgvswld/uakjWhrfmXqpnA9AE9LgaR7khvZRiKV51J3g2Z3uIe6CZ3+6hywmsDVrxaNN9+DZsJFSkwLqfqEjp+HvzT8GcLxS5wgAAA==";
/// 2789 bytes.
const MCAP_LZ4: &str = "H4sIAAAAAAACA7WWS0wbRxiA/1mvvWb8gpiUd9Y1TgJNwA6hqEpTFUqUpLJQkdKH1B6Qgw1YwQ/Zi1oiVSFqlSqHtodWXHLpJcdeeqxURWl7rKLmWKmKkksFIQ+HPCAPoP/v/XcCFrlUzUrw7/fNP4+dWe/M+ZHhodFEQIrXwb50/CsVyn3dGHPjqWJPcdaaKuTjB3oHehORqqHinvJMsVgoWfEEeY+l27UXXHYMMf8TsOMv5Y+uUdH06f53uUiPjjRPDToJV/pQD7lcGghY3itgF7rJTCGXsUqzY7nyZDmO/+KjhWzeOmGlcsVM2uCBov9TAJStdBecPZ5JpTOlyJQBrfIIiEF4L1KUbwk4fEqOnDh2KPIFVHzy5Ex22srmx7CtTGkiNZ4px9/P5jKR8mXYELJslbL5ychEKZXLjGXT38OR0Jeg/yox+2BfpJwZlzM+GMyn8oUQhFrFYVebCH0l4KKcmC6krIH+yGcSds5KGDot9RapgV+bE+DBwcaLa6JIkzCeLrVAxP2OB0QUwID6hTYwvDCIjw4xDTQo0hTlUkUfGBpEK5cCsK9yJgnhxSToXtCTAFmQSei8/vYwhJLgDt9UBYsaFpiVJATCS0o2Uba5irL+Vj91RfIYrbWxXzQMdkPoBhjh205+hxuzdWrijmpiXch5ML0k7yrZUO3MT7KiKntvgFlP6p5SdZi1g9SyUlSxkdR9pXyoXiH1QCls2mwm9VCpAKpWUo+UCqJqJ7WiFM6KuYvUqlI4JjNC6rFSDaheJfVEKRymGSX1VKkwqk5Sz5TCkZsxUmtK7US1m9S6Uvgw5h5SG0o1odqLSlzXcZ1R7hAreri5DTx/u80uyhXD1dx5gAsGoMcK3bRwWoIXrqMVF+I1SnWpZtswax8pXSmcEHM/KbdSHah6SHnUCjb6qI9PhdlLfRiqDxP7iFOqV9XGuTMTpOoc1Y5zZ84lIRiWSuHcxeHAPKb5lOt00vxKxSitj9ICyu120oJK7aG0g5QWUg6nrwXTRvEnUjlDnw7jnGZ/QwTMac8/Qb1sF5lnmW8y/8685HyyON7i+DHH2xwvcrzDscLxLsc39a3+HPM95qvMy8ztbjveZ55kfsD8E/ND5jXmR8zHPXZcYf6OeZX5GvNj5m7Djk+YLeanzJeYnzFLL/fL/AHzOvMPzBvMS95NOwheA3W8KsxnmTXmP5hdzE2SqzOfZHYz/8jsYV5lNpiHfXb0Mn/DXMf8F7Nkjvnt6GMuMPuZf2YOMLt5pwoyjwa2bnUXath+OJd6N//LjmbnOZtaNcitbVTr0x73P1/2dlkzhBfvnPQAtTvnSxrTC8aweX+2b2mLJnw5w9hmGTadAJy7WXVHpwFw3gXnQEC1+ERQfRXf4IyuTZnPL7HNAUtWvZPvHYHtz2FH2X++pdpvTN/yS1pzQnPOZsEG520e42+EX6sp0U/xrzkKNSW+r7lkqLbEe4VLPqwtkTEJWy5VEqgt0Rr5xhmak9B16JOF83y4/RfwK2YN5QoAAA==";
/// 5917 bytes.
const BAG1_BZ2: &str = "H4sIAAAAAAACA+3YfVAUZRwH8Of2DjhW0LvzZRTflhIFNQk4IayLE70TdCzjgsAy7mX3YIHdPe8OXzAHQqbBlxyUqQG0SfOVSvAFMZkKfBebRpEGTcVxciYoRfJdAaXfsk9i5Z814x/7ndl5Pvvszj67d799bu55MelNS/z0WVRK5JSXSRNCSAWb4DIoddCyPM0sSXcJHsPhIagvg2BzCDyf7hByea9BAbsasSszl89+qm8fnEfJkSNHjhw5cuTIkSNHjhw5cp7HhPb///eR/ulzLjfj8bACb7DnRfpDl4fNYwyn4SBPIBQ/PzM2YnraeEvaupPOeUjVkd/YK2V9w/EEY33bY1cDQpqG/N7eBmLqkFBlouUnttQYqb+rb9aW3imKQIquzUWNRbR9JKUPLm42jkv03769YkNiu1p/ptk82BhQLi46NJVSgQFNO10oCClKEPKdYS6QViNGId8CRCPobdok9YxoV8WFRhfoG8wlvuutK1M/LyFC/KMIijCrHAQqPrFcmR0T+9Eyc13QSzWlzcLOq8k/7Mi70Dnm+ug3olPed/LiNjs+ol0xQlfK1V7M4fbUqLla4oRxFTKbaPVxxShlbgIqPKLwsQ5FGmpmhSY4aHmZdiMRlGC0Je3Kuje5Oqv1tJC/+kB1zyNr95GH3T3lhGqU8oC7aDQZTL4eHzV5997AQr9j9GfFCk1Vdn7Nif2ejO/2DT1bubXkvJTWjLG7EtvuP3Y++JLlai9fmjluz3Ay6fuCAk3TwmEnL/EV+50V9+0hVSOHTdhs0v8Yd778havW4MLUUG1s5t5JpU2L4z5xWN5pu9Vyrmt+7RQ/24ZHHSdTJrV89RbDNi9IbklmqosOHV6hqVa/MrZ4Rtn6ROHhhaFrrmi/OfjauZ7GC/Wf/rwsKFQblly3+72qbVOnaYiornUHXNs/mDhMNfHQ3ErTxuTDTd+ufLdSt3t+vXGN4fLwBXTLeIuNMutUaatOke1ff6jbmKk5W1c9pfbV2TlvqyuJ8DkN2hVJKuGLAanHpmeVHDXVhZk0Vmtr7eqw5rWNnQWm7pCkVRMqtgSmrS1T3y7apMq9tilTt21rsaKm/pcbCTtInS424BQK769OlRraRYy7b7HJH69JGcQCIPt2xHUosZivKKSyaFci1Ib9G9hISP4dXI59DXwL+zp4jlJyB7RbsW9A+wi7E9oUleQ/wNXYN8FqH8m3wDbs2+A67Dvgwb6S74JzsO+Bj2HfB4/xk/wAvBj7IfgMdhc4TC25G1yI3QO+iC3er95f8mPwx9i94F+xxc81jpSoAJdhE+Cb2Erw7AH4dPAWbB9wD7YvODlAsh+4ClsN9guU7A+2YpPgg9gDwLqBkgPA2diB4KPYA8GjB+GlSPAicEh/Wfj9rRTEsb2Ci3UYwl0Cy3vrFP/uGyvuL3UxhgxG4Bive2k658nwhM8Tj1m8Ns7F0BPgFI6e6snlDI7oKBvjsOsj7E7aSUfbY5gIp80RFeOIcdiZGLszFUbgYL60ZTDpNONkedYrTp0eLy1dNoGx0YybyuxryGcMSfXdFGn4j0POtcyaRv3jNshcGCoqkvIwC0kvyzFwHJ6X9HjdLJ9BOd02jkln6f/pXp7x7KQzR7B5o/XUkida+kR5JN3/Nfs+/fbrniw/i+vUgRqpOAaLP1Vem9ubLj6a4a85QAstw9P9nWIR9U8Z4vXwW4PE6eNPMof79x0XAAA=";
/// 6182 bytes.
const BAG1_LZ4: &str = "H4sIAAAAAAACA+2YS2wbRRjHv7UdPzZ27CRNafCmu+TRB4U6LxIJsWpagYqAikBEqU/u2rtOrMQPvJu2iYQKXLjAHa48hOAAUjnRC0LAiQOcuHDpidC3k6avNA/+n3dShzYXpCJx2E/azO833+x4ZrIzlrfn9Vcnjhw+qh0fPNgvv0BEAVzliu5vQ1komdaZTKVs6790UD3iuHLlUimTK8+WHF2CJrhqarY0vaXuW7TTvPDCCy+88MILL7zwwgsvvPDCi/9j7Gv8/m9yf+kXK1XLtgvlkj4zPxxBlV2Yt/RfkTztR9vuY7umxtg4fj+JqnWlr9FJKCJeF+icj+JyypVCTk9VyoWSc17aQQm1l2qBuYqlT1rlouVU5zJFe9JOjffTkj7hGMWKZe7FfUXzGXu2qOdGhgwrlx0eyObNvDmSHbUG8kZuaDQ3mstao9n8CQlNMWBj0sqYVr5QKjg8dtsx36R3X7QM06pqUyFSZZuoVfuSUrIu0XPT8rGJo89q71PNL89iYEODmm29JTuFoqXZNdqQZNupFkqTWr5qFK1MwfyAno+vEn0u52fKhjMyrJ2RqWNOppF5ec+C1OlbkBKxH6UB3L8sjf+FVTmwJh3GLEJB6ify/yBpRqWZgj7qrn0fpVTtbJrakxfTpEhp6rlw6DWKg5OX8MeXJrWWpt7k5TRul7Cwg0Wj8hWpd7jyCirf9kfS1E1jBsVNqSt5FTc1NUtqgPPXIEH0EGa5jsa2L4JclBW9KuFzpCZYFpF72R+BtrEuISdDdrDcgDSjk50sy2jYH+ROdrHehH4SwADUx1lvoWkLcgrLbQjmoe5mwXAVfJKqsdyFtEKeYFmB4EPVbpZ7kHZID8sqBCNQe1nWIB2QPpZ1CIaj7mHZgDwG2QuhrBw+EVYwNnUf57CeSidkPwvWUsEw1SdZ/LzCkAMsWCwFY1afYmmCdEGeZsHqKZiAepAlhNl+EY0cCaopVqyqomGV+lmwBknMR30nTX1JGYL5pGjgHFJYvGTPZgprn+zl1CCnYuhxpSW80+cmW6DtsTCnhziN5aNX4vBOpMfxANXO8kZKNXZYIIzylFWtv3X7x26T68Iv5HhXX5DcPcoP44Lgi+Axn8uXwB8LvgxeEnzFzw+Gy1dRfib4Gso1wddRHg+4XAN/I3gRHG5yeQlsCL4BPi94GdwedPkmeEbwLfDPgm+Dd4dcvgM+Lfgu+DfBK+D9YZfvgd8TvAr+QzCPt36GIdbBHwreAP8pmNf1kOyiBP5IsA+8KNgPfqlZNAd/KrgJvCo4CH4j6nII/LXgMDgUczkCPilYBn8nuBnc1uJyFDwtOAb+SXALuEucu3HwKfC/OHgfrlPZtzmHOfcoz2G3282juF7I23ykVh+UrD/icA/6B4bx8JnP833wzP+PxrLN3Ld8q2zS3H2al83Gvzm4dfe33X8Pzy/sYwn34Wjn72zHqDoZnpq+eQa0orRKZqOSH6LGkcH9iV1DfHz8DUdV8WomGAAA";
/// Message i has the point (i / 2, -1, inf) in frame map, and nanosecond i of its stamp.
fn check(messages: &[Read], encoding: &Encoding) {
    for (i, (channel, _, data)) in messages.iter().enumerate() {
        assert!(channel.is_of("geometry_msgs/msg/PointStamped"), "{channel:?}");
        assert_eq!((channel.topic.as_str(), &channel.encoding), ("/point", encoding));
        let mut decoder = Decoder::new(data, encoding).unwrap();
        if *encoding == Encoding::Ros1 {
            decoder.u32("seq").unwrap();
        }
        assert_eq!(decoder.u32("sec").unwrap(), 7);
        assert_eq!(decoder.u32("nanosec").unwrap(), i as u32);
        assert_eq!(decoder.text("frame").unwrap(), "map");
        assert_eq!(decoder.f64s("point").unwrap(), [i as f64 / 2.0, -1.0, f64::INFINITY]);
    }
}

#[test]
fn mcap_of_python_with_zstd_and_lz4() {
    for text in [MCAP_ZSTD, MCAP_LZ4] {
        let mut bag = McapReader::read(Path::new("x"), Cursor::new(bytes(text))).unwrap();
        let (messages, notes) = all(&mut bag);
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(messages.len(), 40);
        assert_eq!(messages[39].1, 1039);
        check(&messages, &Encoding::Cdr);
    }
}

#[test]
fn ros1_of_rosbags_with_bz2_and_lz4() {
    for text in [BAG1_BZ2, BAG1_LZ4] {
        let mut bag = Bag1::read(Path::new("x"), Cursor::new(bytes(text))).unwrap();
        let (messages, notes) = all(&mut bag);
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(messages.len(), 40);
        assert_eq!(messages[39].1, 1039);
        check(&messages, &Encoding::Ros1);
    }
}

/// Pages of 512 bytes: a tree of three levels, and messages that lie on several pages.
#[test]
fn tables_of_sqlite() {
    let mut bag = Database3::read(Path::new("x"), Cursor::new(bytes(DB3))).unwrap();
    let (messages, notes) = all(&mut bag);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(messages.len(), 300);
    let start = 1_663_967_375_548_411_329;
    assert_eq!((messages[3].1, messages[299].1), (start - 3, start + 299));
    check(&messages, &Encoding::Cdr);
    let tail = &messages[250].2[messages[250].2.len() - 1550..];
    assert!(tail.iter().enumerate().all(|(k, byte)| usize::from(*byte) == k % 251));
}

/// A recorder that was killed leaves its last messages in the write-ahead log.
#[test]
fn write_ahead_log_of_sqlite() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bag_0.db3");
    std::fs::write(&file, bytes(WAL_DB3)).unwrap();
    assert_eq!(all(&mut Database3::open(&file).unwrap()).0.len(), 0);
    let log = bytes(WAL_LOG);
    std::fs::write(folder.path().join("bag_0.db3-wal"), &log).unwrap();
    let (messages, _) = all(&mut Database3::open(&file).unwrap());
    assert_eq!(messages.len(), 40);
    check(&messages, &Encoding::Cdr);
    // The folder is a bag without metadata.yaml, and says so.
    let mut bag = loc_ros::open(folder.path()).unwrap();
    let (messages, notes) = all(bag.as_mut());
    assert_eq!(messages.len(), 40);
    assert!(notes[0].contains("no metadata.yaml"), "{notes:?}");
    // A page whose checksum is wrong ends the log: what was completed before it counts.
    let mut damaged = log;
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    std::fs::write(folder.path().join("bag_0.db3-wal"), &damaged).unwrap();
    assert!(all(&mut Database3::open(&file).unwrap()).0.len() < 40);
}
