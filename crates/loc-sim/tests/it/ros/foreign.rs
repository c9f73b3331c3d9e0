//! Small bags written by other software: the Python packages mcap and mcap-ros2-support, rosbags,
//! and SQLite itself. Each is gzipped, in base64; the names say the compression within.

use super::{Read, all};
use base64::Engine;
use loc_sim::source::ros::{Bag1, Database3, Decoder, Encoding, McapReader};
use std::io::{Cursor, Read as _};
use std::path::Path;

/// 2279 bytes.
const MCAP_ZSTD: &str = "H4sIAAAAAAACA7WWfUwTdxjHr9df2+PaUloRlSE7sLx0Ci2FMeJSV8deJAsLG06XLRme7YHN+ubdkVj/0BIJambAaEi2qGAWTcgy/2HZP8bFJfMPE5coxuzNSeY2iVBeWl4LpbBr7zkoHf6zzF/Sfn+f53l+1+d6T5+np+trdzdYtKTsZUxcSHixPs5qEtTjoP1l/gB/yOc1V5RXl1uopCXhLuNa/X4fy5stCbuyFRdPP5WLqkOiDmlF/Y7bP5gwHeV4Zx3Eln5rjh8Y0sT1mDFHLscxGZYvWFsYn4fh2UCTh2vhzMKbucHn8vKNPO3xM04VZCfY78kwTLjaHoZ2Mix1iKT8pI2sb3x7J0UebHW5eZe3STjHsM20g+HMe10ehuJIjmdd3haqmaU9TJPLSQoRlVaKYxxkq5f2+shmt4/mq6uoI4GjJNoipKQUPtDsT9yVw8kqXn8qmDAVfE0e2o+Fb2Lh48PDsj9eGxnBw6GQPDo6ijD72JgCjY8riYkJlSYcJrIikQzD5CSZPTWlzpme1myemdHmzs5m5s3N6fKj0Sxqfl5fsLBgKIzFNmxbXMw2xuMbi5aWcoqXlzeVbC61y9AWkx1HuS/Z5eiF7XaE8nYo0NYyJcovV6EXzQSiLBmoIGghUWGFGm0LVmiQ0apFRUFrJiqu1KGSYGXwdt/A16ZzVyhTPRc8Yazbabhs//CNvgJ7Ft5+ytlGFPXcjx2md33S/sP31TfktEdTNHjrjFVb+nf0cUfoTYvG/bHtSgNyfNqH6i1n3BvN43ce3jGEHn/j77ZVqUu21nbf9gzs5b8a0/Xq7/f/9PvJ3u3nexz72GtPdF167vDPD052XWh85HifvTrTpez9rD235reaS6/wmY+OH/my6vM8Q/zEhrbsWM+SUkHZbGezfI3T/X8O5T8sKznV/OSuC/1lP7bj+tnZd4z7tMYHle/F7u3q7CAKvnBHum9clKk6oKJkWBBfrcFysA4DB4BHgG8Bh6SaBR0F/Qh0DPQq6DhoGHQC9FW01t4BHAEeAJ4EzlOIOgXcAjwN3A88AxwHngXeoxR1Dvg8cBR4EHge2KQSdQGYB44B3wReBCYJ+FzgD4CXgC8DLwOHiJQWIqzqDHgqwG3AOPCPwHLgTSQcBz4IrAC+BqwEjgKrgGvVohLAncAZwL8Ck8BGjahqYB+wBvg6sBZYAb0sE7hBu7bXXUhj8ebkK7X5X7qbGCf1uKSQa6+RPJ/off/zEltpWgrP7qyJG/hXd30+OT0jh9ReLm4THT2BzyeNdR7D6vhY2QVWdsmBItWCNFgSp2C4JEuxBiJKUyJXl2ydCUsm7VI88S62/iB+C+zH8NRjUgvswld/uakjWhrfmXqpnA9AE9LgaR7khvZRiKV51J3g2Z3uIe6CZ3+6hywmsDVrxaNN9+DZsJFSkwLqfqEjp+HvzT8GcLxS5wgAAA==";
/// 2789 bytes.
const MCAP_LZ4: &str = "H4sIAAAAAAACA7WWS0wbRxiA/1mvvWb8gpiUd9Y1TgJNwA6hqEpTFUqUpLJQkdKH1B6Qgw1YwQ/Zi1oiVSFqlSqHtodWXHLpJcdeeqxURWl7rKLmWKmKkksFIQ+HPCAPoP/v/XcCFrlUzUrw7/fNP4+dWe/M+ZHhodFEQIrXwb50/CsVyn3dGHPjqWJPcdaaKuTjB3oHehORqqHinvJMsVgoWfEEeY+l27UXXHYMMf8TsOMv5Y+uUdH06f53uUiPjjRPDToJV/pQD7lcGghY3itgF7rJTCGXsUqzY7nyZDmO/+KjhWzeOmGlcsVM2uCBov9TAJStdBecPZ5JpTOlyJQBrfIIiEF4L1KUbwk4fEqOnDh2KPIFVHzy5Ex22srmx7CtTGkiNZ4px9/P5jKR8mXYELJslbL5ychEKZXLjGXT38OR0Jeg/yox+2BfpJwZlzM+GMyn8oUQhFrFYVebCH0l4KKcmC6krIH+yGcSds5KGDot9RapgV+bE+DBwcaLa6JIkzCeLrVAxP2OB0QUwID6hTYwvDCIjw4xDTQo0hTlUkUfGBpEK5cCsK9yJgnhxSToXtCTAFmQSei8/vYwhJLgDt9UBYsaFpiVJATCS0o2Uba5irL+Vj91RfIYrbWxXzQMdkPoBhjh205+hxuzdWrijmpiXch5ML0k7yrZUO3MT7KiKntvgFlP6p5SdZi1g9SyUlSxkdR9pXyoXiH1QCls2mwm9VCpAKpWUo+UCqJqJ7WiFM6KuYvUqlI4JjNC6rFSDaheJfVEKRymGSX1VKkwqk5Sz5TCkZsxUmtK7US1m9S6Uvgw5h5SG0o1odqLSlzXcZ1R7hAreri5DTx/u80uyhXD1dx5gAsGoMcK3bRwWoIXrqMVF+I1SnWpZtswax8pXSmcEHM/KbdSHah6SHnUCjb6qI9PhdlLfRiqDxP7iFOqV9XGuTMTpOoc1Y5zZ84lIRiWSuHcxeHAPKb5lOt00vxKxSitj9ICyu120oJK7aG0g5QWUg6nrwXTRvEnUjlDnw7jnGZ/QwTMac8/Qb1sF5lnmW8y/8685HyyON7i+DHH2xwvcrzDscLxLsc39a3+HPM95qvMy8ztbjveZ55kfsD8E/ND5jXmR8zHPXZcYf6OeZX5GvNj5m7Djk+YLeanzJeYnzFLL/fL/AHzOvMPzBvMS95NOwheA3W8KsxnmTXmP5hdzE2SqzOfZHYz/8jsYV5lNpiHfXb0Mn/DXMf8F7Nkjvnt6GMuMPuZf2YOMLt5pwoyjwa2bnUXath+OJd6N//LjmbnOZtaNcitbVTr0x73P1/2dlkzhBfvnPQAtTvnSxrTC8aweX+2b2mLJnw5w9hmGTadAJy7WXVHpwFw3gXnQEC1+ERQfRXf4IyuTZnPL7HNAUtWvZPvHYHtz2FH2X++pdpvTN/yS1pzQnPOZsEG520e42+EX6sp0U/xrzkKNSW+r7lkqLbEe4VLPqwtkTEJWy5VEqgt0Rr5xhmak9B16JOF83y4/RfwK2YN5QoAAA==";
/// 5917 bytes.
const BAG1_BZ2: &str = "H4sIAAAAAAACA+3YfVAUZRwH8Of2DjhW0LvzZRTflhIFNQk4IayLE70TdCzjgsAy7mX3YIHdPe8OXzAHQqbBlxyUqQG0SfOVSvAFMZkKfBebRpEGTcVxciYoRfJdAaXfsk9i5Z814x/7ndl5Pvvszj67d799bu55MelNS/z0WVRK5JSXSRNCSAWb4DIoddCyPM0sSXcJHsPhIagvg2BzCDyf7hByea9BAbsasSszl89+qm8fnEfJkSNHjhw5cuTIkSNHjhw5cp7HhPb///eR/ulzLjfj8bACb7DnRfpDl4fNYwyn4SBPIBQ/PzM2YnraeEvaupPOeUjVkd/YK2V9w/EEY33bY1cDQpqG/N7eBmLqkFBlouUnttQYqb+rb9aW3imKQIquzUWNRbR9JKUPLm42jkv03769YkNiu1p/ptk82BhQLi46NJVSgQFNO10oCClKEPKdYS6QViNGId8CRCPobdok9YxoV8WFRhfoG8wlvuutK1M/LyFC/KMIijCrHAQqPrFcmR0T+9Eyc13QSzWlzcLOq8k/7Mi70Dnm+ug3olPed/LiNjs+ol0xQlfK1V7M4fbUqLla4oRxFTKbaPVxxShlbgIqPKLwsQ5FGmpmhSY4aHmZdiMRlGC0Je3Kuje5Oqv1tJC/+kB1zyNr95GH3T3lhGqU8oC7aDQZTL4eHzV5997AQr9j9GfFCk1Vdn7Nif2ejO/2DT1bubXkvJTWjLG7EtvuP3Y++JLlai9fmjluz3Ay6fuCAk3TwmEnL/EV+50V9+0hVSOHTdhs0v8Yd778havW4MLUUG1s5t5JpU2L4z5xWN5pu9Vyrmt+7RQ/24ZHHSdTJrV89RbDNi9IbklmqosOHV6hqVa/MrZ4Rtn6ROHhhaFrrmi/OfjauZ7GC/Wf/rwsKFQblly3+72qbVOnaYiornUHXNs/mDhMNfHQ3ErTxuTDTd+ufLdSt3t+vXGN4fLwBXTLeIuNMutUaatOke1ff6jbmKk5W1c9pfbV2TlvqyuJ8DkN2hVJKuGLAanHpmeVHDXVhZk0Vmtr7eqw5rWNnQWm7pCkVRMqtgSmrS1T3y7apMq9tilTt21rsaKm/pcbCTtInS424BQK769OlRraRYy7b7HJH69JGcQCIPt2xHUosZivKKSyaFci1Ib9G9hISP4dXI59DXwL+zp4jlJyB7RbsW9A+wi7E9oUleQ/wNXYN8FqH8m3wDbs2+A67Dvgwb6S74JzsO+Bj2HfB4/xk/wAvBj7IfgMdhc4TC25G1yI3QO+iC3er95f8mPwx9i94F+xxc81jpSoAJdhE+Cb2Erw7AH4dPAWbB9wD7YvODlAsh+4ClsN9guU7A+2YpPgg9gDwLqBkgPA2diB4KPYA8GjB+GlSPAicEh/Wfj9rRTEsb2Ci3UYwl0Cy3vrFP/uGyvuL3UxhgxG4Bive2k658nwhM8Tj1m8Ns7F0BPgFI6e6snlDI7oKBvjsOsj7E7aSUfbY5gIp80RFeOIcdiZGLszFUbgYL60ZTDpNONkedYrTp0eLy1dNoGx0YybyuxryGcMSfXdFGn4j0POtcyaRv3jNshcGCoqkvIwC0kvyzFwHJ6X9HjdLJ9BOd02jkln6f/pXp7x7KQzR7B5o/XUkida+kR5JN3/Nfs+/fbrniw/i+vUgRqpOAaLP1Vem9ubLj6a4a85QAstw9P9nWIR9U8Z4vXwW4PE6eNPMof79x0XAAA=";
/// 6182 bytes.
const BAG1_LZ4: &str = "H4sIAAAAAAACA+2YS2wbRRjHv7UdPzZ27CRNafCmu+TRB4U6LxIJsWpagYqAikBEqU/u2rtOrMQPvJu2iYQKXLjAHa48hOAAUjnRC0LAiQOcuHDpidC3k6avNA/+n3dShzYXpCJx2E/azO833+x4ZrIzlrfn9Vcnjhw+qh0fPNgvv0BEAVzliu5vQ1komdaZTKVs6790UD3iuHLlUimTK8+WHF2CJrhqarY0vaXuW7TTvPDCCy+88MILL7zwwgsvvPDCi/9j7Gv8/m9yf+kXK1XLtgvlkj4zPxxBlV2Yt/RfkTztR9vuY7umxtg4fj+JqnWlr9FJKCJeF+icj+JyypVCTk9VyoWSc17aQQm1l2qBuYqlT1rlouVU5zJFe9JOjffTkj7hGMWKZe7FfUXzGXu2qOdGhgwrlx0eyObNvDmSHbUG8kZuaDQ3mstao9n8CQlNMWBj0sqYVr5QKjg8dtsx36R3X7QM06pqUyFSZZuoVfuSUrIu0XPT8rGJo89q71PNL89iYEODmm29JTuFoqXZNdqQZNupFkqTWr5qFK1MwfyAno+vEn0u52fKhjMyrJ2RqWNOppF5ec+C1OlbkBKxH6UB3L8sjf+FVTmwJh3GLEJB6ify/yBpRqWZgj7qrn0fpVTtbJrakxfTpEhp6rlw6DWKg5OX8MeXJrWWpt7k5TRul7Cwg0Wj8hWpd7jyCirf9kfS1E1jBsVNqSt5FTc1NUtqgPPXIEH0EGa5jsa2L4JclBW9KuFzpCZYFpF72R+BtrEuISdDdrDcgDSjk50sy2jYH+ROdrHehH4SwADUx1lvoWkLcgrLbQjmoe5mwXAVfJKqsdyFtEKeYFmB4EPVbpZ7kHZID8sqBCNQe1nWIB2QPpZ1CIaj7mHZgDwG2QuhrBw+EVYwNnUf57CeSidkPwvWUsEw1SdZ/LzCkAMsWCwFY1afYmmCdEGeZsHqKZiAepAlhNl+EY0cCaopVqyqomGV+lmwBknMR30nTX1JGYL5pGjgHFJYvGTPZgprn+zl1CCnYuhxpSW80+cmW6DtsTCnhziN5aNX4vBOpMfxANXO8kZKNXZYIIzylFWtv3X7x26T68Iv5HhXX5DcPcoP44Lgi+Axn8uXwB8LvgxeEnzFzw+Gy1dRfib4Gso1wddRHg+4XAN/I3gRHG5yeQlsCL4BPi94GdwedPkmeEbwLfDPgm+Dd4dcvgM+Lfgu+DfBK+D9YZfvgd8TvAr+QzCPt36GIdbBHwreAP8pmNf1kOyiBP5IsA+8KNgPfqlZNAd/KrgJvCo4CH4j6nII/LXgMDgUczkCPilYBn8nuBnc1uJyFDwtOAb+SXALuEucu3HwKfC/OHgfrlPZtzmHOfcoz2G3282juF7I23ykVh+UrD/icA/6B4bx8JnP833wzP+PxrLN3Ld8q2zS3H2al83Gvzm4dfe33X8Pzy/sYwn34Wjn72zHqDoZnpq+eQa0orRKZqOSH6LGkcH9iV1DfHz8DUdV8WomGAAA";
/// 35840 bytes.
pub(crate) const DB3: &str = "H4sIAAAAAAACA+2dd3hURRfGzxAIvZfQAkvvvYYaSqghQAi9hEACBgkEEjooGywIqKAgRUUsYMGCXQEBFRQUkF6ld4UFG3b97oY97Ds5hw/I9/3hI9lHJ3kv+9u5M2fO3HsneTM9uofHJ8e5ho0emxCT7KpHmcgYCnW5iCiz83878r8CfMf4Zejmr8xUc6jJ4v0uU6rOQhmvf9QrtzeQZic5/2W8/g2vGiaQinUsmLtW4uj4UcnD40YnxCWPnRSdkDQ8qZZT1OrmPdwjOSYhMS52aOxYb0JWMpW9ZDvzu7lqvjMXzTlz0hwxB8xus91sMRvNerPavGtWmZVmhVlmlpj55hEz06SYqWa8STQjTKwZZPqYSBNu2plQ08TUNzWvfeS/6hWWUt4p26aUdMrWKYWcslVKLqcMTfHOik3dU52yiXucU4a4E5yysTvOKRu6BzplA3dPp6zj7uKUtd1hTlnT3dwbLXcDp6zuruGUVd0VnLKiO9gpK7gLO2V5tzc9y7q9QSozzSlc3k8v7f3wYO9nF491imIDnKJolFMEhTtF4bZOUaiZUxSs7xT56jpF3mpOkaucU+Qs4RQ5CjpF9pxOkS3AOy1nN0O87WtjLpujZptZa14xi8wDJvna4YzX//xqljsgMFNQ0OIZ+Yd5thlvTBvBkVV0xTlSC448RrucI9XgyDh61zlSDo70oUXOkVK5AgKN70jTKc6BInCgpHdk5PEfuPSnd8jlhgPHSudOvbAPItOF3ne+/D9e7oKZsgYFBxv3pOTeAYFBlYLNpPhRsXETk+MT4pK8E090fOxE59ukmOFxSZnbRIa1igpzdYxoG9bHZb3F1TXCxW9zVb7+T65WPdpUgTpihoyM47fx1wDfp0a1ah0edv1DKsfHOvVEhbUPi3R1i+zYpVVkX1fnsL7Vk0cnxg+Nhn+M6BrliugZHl7dX6n4J1dsTHKMq3V419bXj1Vx1zZZg4oVMylNU88q9XOTrpWZrDO6duxG5zMqJiHOFRXWJwpOZFJi2kNJcWPjY0bGT45Jjh89Ktp3A2e/ZfSwYXFj42Kjx4xOik4cO3pY/EinJ623VHHilbVM2XLlK1SsVLlK1WrVa9SsVbtO3Xr1GzRs1DikSdNmzVu0DG3Vuk3bsHbtO3Ts1Dm8S0TXbt0je0T17NW7T99+/QcMHBQ9OGbI0Ni4YcPvih9x98iEUaMTx4xNSh43fsLESZOnTJ12z73T3Skz7rv/gQdnPjRr9pyHH3l07rzHHp+/4ImFixYvefKpp5c+s+zZ555/YfmKF196+ZWVr772+hur3nzr7Xfefe/9Dz5cvWbtR+vWb/j4k083bvrs881bvvhy67btX+3YuWv3nr379h84eOjw10eOHjt+4uSp02fOnjt/4ZtvL17yXL7y3fc//PjT1Z9/+fU3MpkCMmcJzJote46cuXLnyZsvf4GChQoXCSparHiJksGlSrvu+KZ7EzYj8ndu06/N/87tx/N0l/fLf32FBGSh7IGxvovHp94nwKy+RzvvLVBCTKLvjVda+r6u9329NyQTop8wagR6XKCzIpxb2uyBC3L54I8ZJgHzyw9njIMbN93poEBv/LNRZTKbzCzT1RSig7SUhpK4ew/JifH7kkOQQ4SgUKgIfQ5Ev2A0u0ALSDQ7olsYzSbQfBLNhuhmRrMKNJdEsyL6OaOBAs0m0UBEP2M0i0AzSzQLopsYzSwHuUQzI7qO0QCB/iKS65bjXxCr2M1VFBBVlJVnVwDRXYzmF2gZieZHdCej+QTqkmg+RHcwmlegpSSaF9GvGM0j0JISzYPodkZzC7S4RHMjuo3RXAItKtFciG5lNKdAi4SmO/4lsIrDXEVxUUVVeXbFET3EaDGBVpFoMUQPMlpUoJUlWhTRA4wGCbSSRIMQ3c9oEYFWlGgRRPcxWligFSRaGNG9jBYSaHmJFkJ0D6MFBVou/fEvh1Wc4irKiirqyLMri+hJRsukRafXlmgZRE8w6hK1KqgL0eOMlhZoLYmWRvQYo6UEWlOipRA9ymiwQGtINBjRI4yWFGh1iZZE9GtGSwi0mkBzpDZsCplt5kdzzhwyG8zbZoVZbOaYe81YE2f6mM6mhaljypsgk4P+pCt0ivbRFlpLb9BztIBmOvAoiqEoa7hUuoV1AliHOArrGJeOBIP4uiSIwyVAHCoO4mAxEAeKgtgfBGIfLI9c2lsYxJ5CIHYXBLGrAIid+UHsyAfiq7wgtuOqyzZccdmaC8SXOUF8kQPEluwgNmcD8XlWEJ8FgtiUBcS6zCA+DQDxSaacAYHZ+V46h1nujM4eZGqbH8xZU84UMdnpD7pMJ2kvbaY19Do9S/PpQZpMCTSYephFZra5x4wxsaa36WSam4Nmq1lv3nI+RonrD/VAfF8XxHd1QFypDeJyLRCemiAu1QBxsTqIb6uB+KYqiAtVQJyvDOJcJRBnK4I4UwHE6fIgTpUDcdwF4vemIH5rAuLXEBC/NAbxcyMQVxuC+KkBiB+967j1b3cVDj7gj2YgTpYFcaLMLc//1XCK+ZanmKpiimkgZ6eqiH7DaBUx/9eXaBVELzBaWdSqoJURPc9oJVFrPYlWQvQcoxVFrQpaEdGzjFYQtdaVaAVEzzBaXtSqoOURPc1oOVFrHfX6n9UJeJr4/z9fIXXx7L7ns6sjzq6xbFgdRL9jtLboEwWtjegVRmuJWhtJtBailxmtKWpV0JqIehitIWptKNEaiF5itLqoVUGrI3qR0WqiVpmc3me4jDW9O7fp3lGQEfk7t+m5U9dvGxKN8Ra3PKXXxwnnR55w6okJJ0RMOLOpXupqbiLfIjJcV0x0Es4YB//PpnsX4W75/q8ZRvwPDlpTEfHm8urUFNHfGW0i4q2gTRD9jdEQUWsziYYg+iujjUWtCtoY0V8YbSRqbSrRRoj+zGhDUauCNkT0KqMNRK1NJNoA0Z8YrS9qbZL+9Z+2UIUnM1fRJm0VG0Ll2bVBNIDR1qJhCtoa0UyMtkqLhipoK0QNo6GiTxQ0FFFitKU44ZYSbYmR+JvRFqJWBW2B6F+MNhe1tpBoc0T/ZLSZqFWiOcx6KuV9/vc+y3vXAJwneecZ/+brAP5VgLPX1gCUJ09P4Z4gCkWBKNgDRIFIEPm7g8jXDUTeriDyRIDI3QVErnAQOTuDyNEJRPaOILJ1AJG1PYjAdiCyhIGgUHiS/rsliL9awNuK9wNRrC+Ion1ABPUGUaQXiMxtQQS0AZGp9W0vtXlK9AdhWt1y/odjTuTiIdZZ5H9rOTo7I5qT0U5iYCtoJ0RzMNpR5L+CdkQ0O6MdRE4oaAdEszHaXrS1lUTbI5qV0XairQraDtFARsNEWxU0DNEsjLYVbW2V/vk/CqsoxFX0EH3SVp5dD0QLMhop+kRBIxEtwGh30ScK2h3R/Ix2E32ioN0QzcdoV9HWNhLtimheRiNEWxU0AtE8jHYRbVXQLojmZjRctLVN+uM/AKsoyVX0F33STp5df0RLMNpP9ImC9kO0OKN9RZ8oaF9EizHaR/SJgvZBtCijvUVbwyTaG9EgRnuJtipoL0SLMNpTtFVBeyJamNEo0daw9Mc/Fqsoz1UMFX3SQZ7dUETLMTpE9ImCDkG0LKMxok8UNAbRMowOFn2ioIMRdTEaLdraXqLRiJZmdJBoq4IOQrQUowNFWxV0IKLBjA4QbW2vrf+VzFjTuXOb7h0FGZG/c5ue6v/yPtq2TNfPdmbXjfOu5j0R5Zt7KvDcEyvmno4Zq3n/sHHg/RWRa7//MSHA+wxP9137Sb7z/B9jokx708TUMC5T0ATSr3SRjtEu2kQf0ErnDmFe6vP/KO/vDNAEGuFcpbqlWkLN7T+QNpkMonQ0iPrJIOolgag7FkSdMSBqJ4KoNRpEzVEgaiSAqD4SRLW7QVQdAaJKPIjKd4GoNBxExWEgKsSBKB8LotEEuxsajgfRYByIckNBlB0CokwMCNdgEKUGgQgeCCJkEojGE2/5/i8BbzFqcJqPFGneWd6djES0OqN3i9upThK9G9FqjI4Qt1MKOgLRqozGi9spBY1HtAqjd4m2KuhdiFZmdLhoq5wNQ4YjWonRYaKtCjoM0YqMxom2dkz//f84rKIBV5Es+qSLPLtkROszmiT6JFyiSYjWY3Ss6BMFHYtoXUbHiD5R0DGI1mE0UbRVQRMRrc3oaNFWJU1GI1qL0VGirQo6CtGajCaItnZOf/ynYRXNuYqpok+6yrObimgzRqeIPomQ6BREmzI6WfSJgk5GtAmjk0SfKOgkREMYnSjaqqATEW3M6ATRViVNJiDaiNHxoq0KOh7RhoyOE23tcoP4l70W/whTgPbREudxtSxE3o3GBE8Yf/p94sS6yRNzozPB05bZGWnZwRqLbiNPG2ZTRKs0Fu1GntbMutOyLo01yLZidroIv8YSsqHM3ivir6TJvYi2ZPQe0c0Keg+iLRidJnqqq/r7vyW9afwCLaRZzv3cGbPfbDFrzGvmGTPPzDDjzHDT13Q2zU0tU8a5F8xCP9MFOkzbaD296YCjaDBFenoSpXqTfR6AW/zbE343c29aCLclLe4B0XwaiGZTAepFT4DqSQtARdF8UD3ocVCR9Bio7jQPVDeaC6orPQoqgh4B1YUeBhVOc0B1ptmgOtEsUB3pIVAdaCao9vQgqHb0AKgwuh9UW7oPVBuaAao1pYBqRW5QoTQdurOlL/9dZDaamSbc5KM9tIgGpP6GvS/70ZbiNNo3tuaIYdldyQb0pThd5GNni+zXWDScOR3qY2eJMa2x6Dhzut/HPiSyX2PRcuYEy8fOFNmvseg5c0LrYx9Myx7XZg40nTkDwcc+IGYOjUXXmTNsfOz9adll3W4w//+3+KMtxUky32fPF/GPVM4LfSlOSvrYx0X8NRYNZ04C+9jHRPw1Fh1nTrr72Hki/hqLljNncvCxc0X8NRY9Z85U4mMfFfHXxg6azpyJx8c+IuKvseg6c6YpH/uwiH/3G8S/hjf+C5x5PphO0HLnIUl3Aoe40aPiGcgVPSUGQw/lJNGk4hnA7JNiMGgsus88/ZldIgaDxqL9zNOP2cViMGgs+s88fZldJAaDxqIBzdOH2YViMMiBNDvWHeRdVlvY+Prl0Uc/oVieK4W40XXmXBZ9b14g4h+prf9X3hCZsTR3p65Oe40YGYvzd27TvemeEfl/QdPTac65+f0f2pI8cXxteUFc8qOUSyD6kjyxzD4vLvkai4Zjz1BmnxOXfI1Fx7FnCLPPiku+xqLl2BPD7DJx4dVY9Bx7BjP7jLjka7cLaDr2RDO7VNz/aSy6jj2DmH1aXP973OD5fyKZ781ps8+sNq+apaaTaWZqGpcpYDLTVTpPh2grraNVTufPdx5IJpq5JsUkm2Gmj9lMI5zREgED6vaf/UfR66AS6DVQI+lVUHfTSlAj6BVQ8fQyqLvoJVDD6UVQw2gFqDhaDiqWXgA1lJ4HNYSeAxVDz4IaTMtARdMzoJLobVBj6S1QY+hNUIm0CtRoegPUIFoKaiA9DWoAPQUqmd4B1Z+eBNWPloDqS4tvnv9oS3Oi4xtbr4r876mMS/SlObH0sStF/mssGk6dyPvYV0T+ayw6Tp1x4mNfFvmvsWg5dUaVj31J5L/GoufUGYM+9kWR/9rcgaZTZ8T62BUi/zUWXafO+Paxy0X+R6Xj+R+9BZ5x/NnviPj3Us4LbULOuPSxb4v4a2w9ZJOYfUvEX2PRcepknI99U8RfY9Fy6uSnj10l4q+x6Dl1stnHviHir40dNJ06ue9jXxfx11h0nTrzqY99TcS/Zzrij94CzzT+7LUi/r2V80LTkGcqs2tE/DUWXUOeKcyuFvHXWLQNeSYz+6GIv8aib8gzidkPRPw1Fo1DnonMvi/ir40ddA55JjD7noi/xqJ1yDOe2XdF/Hv9E6//s+lLULPoC1AP0RZQM2kzqAfpc1AP0Geg7qdNoO6jjaBm0KegUugTUG76GNR02gDqXloP6h5aB2oafQRqKq0FNZd2gHqUvgL1CG0H9TBtAzWHtoKaQmtATabVoCbRh6Dm0U5QE+kDUBPofVDj6b2b57/lLbifx9ZGkf99lHFpmcbuY/ZTkf8aa7nGZjD7ich/jbVsYynMfizyX2Mt35ib2Q0i/zXWMo5NZ3a9yH9t7kDnmDPWfOw6kf8ai9YxZ2T62I9E/vf+b+u/3vjfbP3XMho8zBVtFYOhr3KSloNoDrNfisGgsZaFaDazX4jBoLGWh2gWs1vEYJDsnCLujt512EUlr09HPnqzsg5bN8RtGYdm8ps/F/HXxo7lHHqQ2c9E/DXWsg49wOwmEf8+2vpvPeqbsf57B6//1s9Y/81Y/82I/B3X9Ftc/7W8ZQv42rJHXPL7KdclyzQ6n9nd4pKvsZZr9HFmd4lLvsZattHHmN0pLvkaa/lG5zG7Q1zwNdYyjs5l9itx/dduUyzn6KPMbhfXf421rKOPMLtNXP/7puP53/KWPc2f/bWIf3/lvCzT6FPMHhbx11jLNfoks4dE/DXWso0uYfagiL/GWr7RxcweEPHXWMs4uojZ/SL+2tixnKMLmd0n4q+xlnX0CWb3ivj3U5//g52H+PQ//zv/X3/+d76vegtP/G/QZVAv0XlQL9I5UCvoLKjldAbUC3Qa1PN0CtRzdBLUs3QC1DI6DuoZOgZqKR0F9TQdAfUUfQ3qSToMagkdArWYDoJ6jS6BepUuglpJ34J6hb4B9TJdALWIDoBaSPtBPUH7QL1OHlALaC+o+bQH1OO0++b5H4djazmPrdMi/wco49IyDb/A7CmR/xpruYafZ/akyH+NtWzDzzF7QuS/xlq+4WeZPS7yX2Mt4/AyZo+J/NfmDss5/AyzR0X+a6xlHV7K7BGR//3TMf9bxp/X+LMvivgPVM7Lcv68yuy3Iv4aa1l/VjL7jYi/xlren1eYvSDir7GW+edlZs+L+Gus5f55idlzIv7a2LHsPy8ye1bEX2Mt/88KZs+I+A9IR/wt48+7/Nk/ivgPUs7Lcv68w+wPIv4aa1l/3mb2exF/jbW8P28x+52Iv8Za5p83mb0i4q+xlvtnFbOXRfy1sWPZf95g1iPir7GW/+d1Zi+J+A+8wd9/bYbxn5j6h6Nu5a8Aui1nz1qu93cR32i5tNbBPcW7tLaYfPQapn8TEY6+jeUp71/MCnFb3p/V/Mm/ivhHK31pmX8+ZPYXEX+Ntdw/HzD7s4i/NnYs+8/7zF4V8ddYy//zHrM/ifgPuvHPf/aZzbd99+e9Z0z97n/6+c8mkwXURpMZ1KcmANQnJhOoj40BtcHgZ66nv0Gto79AfUR/glpLf4BaQ7+DWk2/gfqQfgX1Af0C6n36GdR7dBXUFyYHqC0mO6jNJhuoz01WUJ+ZQFDv0k+g3qEfQb1NP4B6i74H9SZ9B2qryQXqS+PdIqRFxvLOndt0758izIj8ndt071ycEfk7t+k3vf9PsRy8G6/vLWbS3FvUHizvS1IsB69/v8C0rEtjLQevf8PAtGw+jbUcvP79AtOypLGWg3cDs3+Lezjt/s+y8K5n9i9xD6exlof3+h5uf4p7OI21zPkfMfuHeEaLvv3nvxTLw+nfWyxtX67S+tLycPo3DUzLLtNYy8Pp3zUwLTtXYy0Pp3/bwLTsdI21PJz+fQPTsokaa3k4/RsHpmUHa6zl4fTvHJiW7aaxlkPfv3VgWjZ0cDrib3k4/XuLifyPUc7L8nD6Nw0U+a+xlofTv2ugyH+NtTyc/m0DRf5rrOXh9O8bmJa9osXB8nD6Nw5Myx7XWMvD6d85MC27Q2Mtj7Z/68C07IbB6vNfaYogeKq7yfPftd/48/28wPfMqDzVnTEVQJ025UGdMriT+UlTFtQJUwbUceMCdcyUBnXUlAJ1xASD+tqUBHXYlAB1yBQHddAUA3XAFAW13wSB2meKgNprCoPaYwqB2m0KgtplCoDaafKD2mHygfrK5AW13eQBddFUB/Wtwd3hvzFVQV0wVUCdN5VBnTOVQJ01FW+e/5Zt17+3nJj/tVyybLv+TSPF/K+xlm3Xv2ukmP811rLt+reNFPO/xlq2Xf++kWL+11jcONLj3zhSzP8aa3l4/TtHivlfYy2Pvn/rSDH/x6Rj/rc8XP69pcT8P0Q5L8vD5d80Usz/Gmt5uPy7Ror5X2MtD5d/20gx/2us5eHy7xsp5n8tDpaHy79xpJj/NdbycPl3jhTzv8Zatnz/1pFi/k9P/C0Pj39vKZH/Wl9aHh7/pnEi/zXW8vD4d40T+a+xlofHv22cyH+NtTw8/n3jRP5rrOXh8W8cJ/JfYy0Pj3/nOJH/Gmt5NP1bx4n8l+x/APqInDwAjAAA";
/// 1536 bytes.
pub(crate) const WAL_DB3: &str = "H4sIAAAAAAACA+2Tv07DMBDGzymoU6YOVYZKN1IpIgMvQIIsFBHSkgaJTpFJTGSp+aPYDGHLKzLyNCQtgRSE2BigP1nn83e29Ulnr248oTg+FFXGFJ6BBpoG54gAbQowgg+69dFgTeBnNDiNib5NXoCUbfg1mok2ns5mpKkVu9/wjEvJUi77eXQRUDukGNqOR7FXT0SCrh/SSxrgMnCv7WCNV3RtqqIUcTQo+osQ/VvPM5VozyqWlV9LmDDF0PEWzrs2b3QynhoGaR63rrb3yl3U9hzttO/85CzjGNK7cGCkLj9LkleCbcQTU6LIo7ce722Zd70h5BnaceBPYJJjMNyJVRYiVykvMq6qOspkKq02WMtOXnUPlidxUun9zz7wL3kF+zaxnQAGAAA=";
/// 3784 bytes.
pub(crate) const WAL_LOG: &str = "H4sIAAAAAAACA+3WS0wTQRgH8JntGyggIFCgMEDLQ8FXD15MBExjjBUVq8FEY1ap2mil0nrAi6KeNBqNifHgwasnD8aLF40mxkBivHjQgxqNxjfFBz7wtduvH1b+NXLyYPwOs92Z/e03nfl2swv32Q+I9oeVQmjCCLlx+w3L8JFLG++c3BFPNd+8b/aZA9x//cruzZ4Tp1esWR2KJiNqa/9ATE+qgKE1TXQoJehGTvEzzHNr1rkUfw5NzNki3ekfd4WMG81fi6FSzVHh9cqhwaS+eWckFkkk9G2RBB8tS3qCneGgCnd2hYKKe1uifWpZdzi4NNijVvUsW9HZs14tD65vS/bHo1s2ZQ12rwyr7rWhUFsyatikHovjkOrTk7rqCq3smuxrHXJLR4XHI4f2pGeVvm+CWu2XGVHf7+azS49FVDjYG86ayGB8alciMhDVd0b36slo/65NmT3+5ZJWY6Es2XXhHbl2wb/h/XGbudnypTnklBNyXI7Ryf/4J8PhMxp7tdHYSsydd/GzznVx8MnhM5/Ojd0yn2WXaBRyRJ6SumwTH8RVcVT0Gl0cAZdNuLQ+S8p8QzgyLxHzZjE9nrmkuIOOqcuZ476Ak9AoIwegAkQOQq8Z2QE5EdkJvWJkA2RFZCP0kpEVkEBkJfSCkQXQx8WALISeM9IApRBphJ4xkoAeIJKEnjIS+J/EVJRZr8m6mO27eE6sOzQxnboooXyfON8MyFePaziD0EdGxYAUomJCHxgVAapFVERonFEhoBpEhYTeM3IDqkLkJvSOUQGgSkQFhN4yygdUjiif0BtGeYDKEOURGmPkAlTSkaMu7Nl1MXx+0RvlH789nbqoTuezapyvCvLNwklWEZKMPIBaEXkICUaVgFoQVdJyfGdUAagZUQWhb4zKATUhKif0ldFMQH5EMwl9YVQGyIeojNAEo1JAjYhKCX1mVAKoIVddOLLr4t6x0SWPH51tn05d+Gi38jlf49R8++fjJBsJ5TFqgEnmQA2EXIzqIdM8RPWEnIwUZMqBFCEHozpAcxHVEbIzqgU0B1EtIRsjL6B2RF5CVkY1gNoQ1RCyMKoGNDtXXZifBU6uCz2w/d3VWanH6fenUQ6TdfE/fhuBFlr4Il74ZijbAO5WM6FCRk2wWzlQEyE3Iz9kWoDIT6iAkQ8yIfoB6UoWA8gOAAA=";

pub(crate) fn bytes(text: &str) -> Vec<u8> {
    let packed = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
    bytes
}

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
    let mut bag = loc_sim::source::ros::open(folder.path()).unwrap();
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
